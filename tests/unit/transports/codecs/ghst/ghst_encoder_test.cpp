#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_ghst.h"
#include "tests/support/streams.h"
#include "transports/codecs/ghst/ghst.h"

namespace tribus::test::ghst_encoder_test {
namespace {

using namespace std::chrono_literals;
using reference::PlainGhstFrame;

constexpr Instant kStart = Instant(1h);

ChannelFrame good_frame() {
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    return frame;
}

ChannelFrame all_at(Pulse pulse) {
    ChannelFrame frame = good_frame();
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        frame.set(channel, pulse);
    }
    return frame;
}

Bytes encoded(GhstEncoder& encoder, const ChannelFrame& frame, Duration at) {
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder.write(frame, wire, kStart + at);
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

/// The frame as the plain form reads it.
PlainGhstFrame sent(GhstEncoder& encoder, const ChannelFrame& frame, Duration at) {
    const Bytes bytes = encoded(encoder, frame, at);
    EXPECT_EQ(bytes.size(), 14U);
    const auto frames = reference::plain_ghst_frames(bytes);
    EXPECT_EQ(frames.size(), 1U);
    return frames.empty() ? PlainGhstFrame{} : frames[0];
}

/// The frame with the statistics, which comes behind the first three.
PlainGhstFrame sent_statistics(const ChannelFrame& frame) {
    GhstEncoder encoder;
    for (int i = 0; i < 3; ++i) {
        sent(encoder, frame, 0ms);
    }
    return sent(encoder, frame, 0ms);
}

TEST(GhstEncoder, WritesTheFramesOfTheSources) {
    GhstEncoder encoder;
    EXPECT_EQ(encoded(encoder, all_at(kCentrePulse), 0ms),
              from_hex("820C3000088000088080808080D2"));
    // ArduPilot, test_ghst_resync.cpp, make_frame of 1.
    ChannelFrame frame = all_at(Pulse::from_fractional_microseconds(1253.25));
    for (std::size_t i = 0; i < 4; ++i) {
        frame.set(4 + i, Pulse::from_microseconds(1452 + 4 * static_cast<int>(i)));
    }
    GhstEncoder other;
    EXPECT_EQ(encoded(other, frame, 0ms), from_hex("820C30255442255442747576776C"));
}

TEST(GhstEncoder, GroupsComeByTurnsAndStatisticsBehindATurnTenTimesASecond) {
    GhstEncoder encoder;
    std::vector<int> types;
    std::vector<Duration> statistics_at;
    for (Duration at = 0ms; at < 320ms; at += 4ms) {
        types.push_back(sent(encoder, all_at(kCentrePulse), at).type);
        if (types.back() == 0x33) {
            statistics_at.push_back(at);
        }
    }
    EXPECT_EQ(std::vector<int>(types.begin(), types.begin() + 8),
              (std::vector<int>{0x30, 0x31, 0x32, 0x33, 0x30, 0x31, 0x32, 0x30}));
    EXPECT_EQ(statistics_at, (std::vector<Duration>{12ms, 112ms, 212ms, 312ms}))
        << "behind a turn, 100 ms after the latest";
    for (std::size_t i = 3; i < types.size(); ++i) {
        EXPECT_NE(types[i], types[i - 1]);
        EXPECT_NE(types[i], types[i - 2]);
    }
}

TEST(GhstEncoder, EveryFrameHasTheNearestRawValueOfItsChannels) {
    GhstEncoder encoder;
    for (std::int32_t eighths = 7000; eighths <= 17000; ++eighths) {
        const PlainGhstFrame frame = sent(encoder, all_at(Pulse::from_eighths(eighths)), 0ms);
        const double us = eighths / 8.0;
        const double fine = std::fmin(std::fmax(std::floor((us - 988) * 4 + 0.5), 0), 4095);
        const double coarse = std::fmin(std::fmax(std::floor((us - 988) / 4 + 0.5), 0), 255);
        for (std::size_t i = 0; i < 4; ++i) {
            ASSERT_EQ(reference::plain_ghst_fine(frame, i), fine) << us;
            if (frame.type != 0x33) {
                ASSERT_EQ(frame.payload[6 + i], coarse) << us;
            }
        }
    }
}

TEST(GhstEncoder, WritesEveryRawValueOfEveryChannel) {
    GhstEncoder encoder;
    for (unsigned raw = 0; raw <= 4095; ++raw) {
        ChannelFrame frame = good_frame();
        std::array<unsigned, 16> raws{};
        for (unsigned channel = 0; channel < 16; ++channel) {
            raws[channel] =
                channel < 4 ? (raw + 1001 * channel) % 4096 : (raw + 17 * channel) % 256;
            const double us = channel < 4 ? reference::plain_ghst_fine_us(true, raws[channel])
                                          : reference::plain_ghst_coarse_us(true, raws[channel]);
            frame.set(channel, Pulse::from_fractional_microseconds(us));
        }
        for (int turn = 0; turn < 3; ++turn) {
            const PlainGhstFrame plain = sent(encoder, frame, 0ms);
            for (std::size_t i = 0; i < 4; ++i) {
                ASSERT_EQ(reference::plain_ghst_fine(plain, i), raws[i]);
                if (plain.type != 0x33) {
                    ASSERT_EQ(plain.payload[6 + i], raws[4 + 4 * (plain.type - 0x30U) + i]);
                }
            }
        }
    }
}

TEST(GhstEncoder, LimitsPulsesBeyondTheEnds) {
    for (const auto& [eighths, fine, coarse] :
         {std::tuple(-32768, 0U, 0U), std::tuple(32767, 4095U, 255U)}) {
        GhstEncoder encoder;
        const PlainGhstFrame frame = sent(encoder, all_at(Pulse::from_eighths(eighths)), 0ms);
        EXPECT_EQ(reference::plain_ghst_fine(frame, 3), fine);
        EXPECT_EQ(frame.payload[9], coarse);
    }
}

TEST(GhstEncoder, CentresAbsentChannelsAndSendsTheirGroups) {
    GhstEncoder encoder;
    EXPECT_EQ(encoder.needed_channels(good_frame()), 0xFFFFU);
    for (const int type : {0x30, 0x31, 0x32}) {
        const PlainGhstFrame frame = sent(encoder, good_frame(), 0ms);
        EXPECT_EQ(frame.type, type);
        for (std::size_t i = 0; i < 4; ++i) {
            EXPECT_EQ(reference::plain_ghst_fine(frame, i), 2048U);
            EXPECT_EQ(frame.payload[6 + i], 128);
        }
    }
}

TEST(GhstEncoder, StatisticsHaveTheLinkQualityIfItIsKnownAndTheValuesAreNew) {
    ChannelFrame frame = all_at(kCentrePulse);
    EXPECT_EQ(sent_statistics(frame).payload[6], 0) << "not known";
    frame.link_quality = 73;
    EXPECT_EQ(sent_statistics(frame).payload[6], 73);
    frame.frame_lost = true;
    EXPECT_EQ(sent_statistics(frame).payload[6], 0) << "held";
    frame.frame_lost = false;
    frame.failsafe = true;
    EXPECT_EQ(sent_statistics(frame).payload[6], 0) << "preset";
}

TEST(GhstEncoder, StatisticsClaimNoSignalStrengthAndAskForNoTelemetry) {
    const PlainGhstFrame frame = sent_statistics(all_at(kCentrePulse));
    EXPECT_EQ(frame.type, 0x33);
    EXPECT_EQ(frame.payload[7], 117) << "-117 dBm, Betaflight's 0 %";
    EXPECT_EQ(frame.payload[8], 7) << "Pure Race";
    EXPECT_EQ(frame.payload[9], 0);
}

TEST(GhstEncoder, IsSilentInFailsafe) {
    GhstEncoder encoder;
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    EXPECT_EQ(encoder.write_silence(wire, kStart), 0U);
}

TEST(GhstEncoder, TheDecoderReadsAllSixteenChannelsAfterOneTurn) {
    ChannelFrame frame = good_frame();
    for (std::size_t channel = 0; channel < 16; ++channel) {
        frame.set(channel, Pulse::from_microseconds(988 + 64 * static_cast<int>(channel)));
    }
    frame.link_quality = 91;
    GhstEncoder encoder;
    GhstDecoder decoder;
    std::vector<DecodedFrame> frames;
    for (int i = 0; i < 4; ++i) {
        feed_into(frames, decoder, encoded(encoder, frame, 0ms));
    }
    ASSERT_EQ(frames.size(), 4U);
    EXPECT_TRUE(frames[2].channels.same_content(frame));
    EXPECT_TRUE(frames[3].channels.same_content(frame));
    EXPECT_EQ(frames[3].channels.link_quality, 91);
}

}  // namespace
}  // namespace tribus::test::ghst_encoder_test
