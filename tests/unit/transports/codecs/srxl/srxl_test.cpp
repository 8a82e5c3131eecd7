#include "transports/codecs/srxl/srxl.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_srxl.h"
#include "tests/support/channel_bytes.h"
#include "tests/support/heard_line.h"
#include "tests/support/streams.h"
#include "transports/registry/registry.h"

namespace tribus::test::srxl_test {
namespace {

using namespace std::chrono_literals;
using reference::plain_srxl;

// Computed from the layout in ArduPilot's AP_RCProtocol_SRXL.cpp.
constexpr std::string_view kVersion1 = "A1000008000FFF0800080008000800080008000800080008002BF4";
constexpr std::string_view kVersion2 =
    "A2000008000FFF0800080008000800080008000800080008000800080008000800DA2E";
// ArduPilot, RCProtocolTest.cpp, srxl_bytes: a recording of an AR7700.
constexpr std::string_view kVersion5 = "A5030C042F6C10B42616340104761C40F53B";
constexpr std::uint8_t kConnected = 0x02;

using Line = HeardLine<SrxlDecoder>;

TEST(SrxlDecoder, ReadsTheFramesOfTheSources) {
    std::vector<double> expected(12, 1500);
    expected[0] = 800;
    expected[2] = 2199.625;
    Line line;
    EXPECT_EQ(pulses_of(*line.hear(from_hex(kVersion1), 0ms)), expected);
    expected.resize(16, 1500);
    EXPECT_EQ(pulses_of(*line.hear(from_hex(kVersion2), 14ms)), expected);
    const auto captured = line.hear(from_hex(kVersion5), 28ms);
    ASSERT_TRUE(captured);
    EXPECT_TRUE(captured->good());
    EXPECT_EQ(pulses_of(*captured),
              (std::vector<double>{1567.375, 1502.25, 1018.25, 1536.5, 1804.75, 2000, 1500.625}));
}

TEST(SrxlDecoder, ReadsEveryRawValueOfEveryChannelToTheNearestEighth) {
    for (const unsigned version : {1U, 2U}) {
        SrxlDecoder decoder;
        for (unsigned raw = 0; raw <= 4095; ++raw) {
            std::vector<unsigned> words(version == 1 ? 12 : 16);
            for (unsigned i = 0; i < words.size(); ++i) {
                words[i] = (raw + 273 * i) % 4096;
            }
            const auto frames = feed(decoder, plain_srxl(version, words));
            ASSERT_EQ(frames.size(), 1U);
            const auto values = pulses_of(frames[0].channels);
            ASSERT_EQ(values.size(), words.size());
            for (std::size_t i = 0; i < words.size(); ++i) {
                ASSERT_EQ(values[i], reference::plain_srxl_us(words[i])) << words[i];
            }
        }
    }
}

TEST(SrxlDecoder, TheUpperFourBitsOfAWordAreNotUsed) {
    Line line;
    for (const unsigned version : {1U, 2U}) {
        const auto frame = line.hear(
            plain_srxl(version, std::vector<unsigned>(version == 1 ? 12 : 16, 0xF800)), 0ms);
        EXPECT_EQ(pulses_of(*frame), std::vector<double>(version == 1 ? 12 : 16, 1500));
    }
}

TEST(SrxlDecoder, ReadsEveryWordOfVersionFive) {
    for (unsigned word = 0; word <= 0xFFFF; ++word) {
        SrxlDecoder decoder;
        const auto frames =
            feed(decoder, plain_srxl(5, {word, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF}));
        ASSERT_EQ(frames.size(), 1U);
        const ChannelFrame& channels = frames[0].channels;
        if (word / 2048 < 12) {
            ASSERT_EQ(present(channels), std::vector<std::size_t>{word / 2048 + 1});
            ASSERT_EQ(channels.channel(word / 2048)->microseconds(),
                      reference::plain_srxl_word_us(word));
        } else {
            ASSERT_FALSE(channels.has_any()) << word << ": X-Plus, or not used";
        }
    }
}

TEST(SrxlDecoder, EachPlaceOfVersionFiveMayHaveAnyChannel) {
    for (std::size_t place = 0; place < 7; ++place) {
        for (unsigned channel = 0; channel < 12; ++channel) {
            std::vector<unsigned> words(7, 0xFFFF);
            words[place] = channel * 2048 + 1462;
            Line line;
            const auto frame = line.hear(plain_srxl(5, words), 0ms);
            ASSERT_TRUE(frame);
            EXPECT_EQ(present(*frame), std::vector<std::size_t>{channel + 1});
            EXPECT_EQ(frame->channel(channel)->microseconds(), 1750);
        }
    }
}

TEST(SrxlDecoder, OnlyTheBitOfTheConnectionSaysFailsafe) {
    for (unsigned flags = 0; flags <= 0xFF; ++flags) {
        Line line;
        const auto frame = line.hear(
            plain_srxl(5, std::vector<unsigned>(7, 0x0400), static_cast<std::uint8_t>(flags)), 0ms);
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->failsafe, (flags & kConnected) == 0) << flags;
        EXPECT_FALSE(frame->frame_lost);
        EXPECT_EQ(present(*frame), std::vector<std::size_t>{1});
    }
}

TEST(SrxlDecoder, AWordCountsForAFifthOfASecondIfLaterFramesLackIt) {
    const Bytes first =
        plain_srxl(5, {1024, 2048 + 1024, 2 * 2048 + 1024, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF});
    const Bytes second =
        plain_srxl(5, {7 * 2048 + 100, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF});
    Line line;
    EXPECT_EQ(present(*line.hear(first, 0ms)), (std::vector<std::size_t>{1, 2, 3}));
    EXPECT_EQ(present(*line.hear(second, 11ms)), (std::vector<std::size_t>{1, 2, 3, 8}));
    const auto last = line.hear(second, 200ms);
    EXPECT_EQ(present(*last), (std::vector<std::size_t>{1, 2, 3, 8}));
    EXPECT_EQ(last->channel(2)->microseconds(), 1500);
    EXPECT_EQ(present(*line.hear(second, 201ms)), std::vector<std::size_t>{8});
    EXPECT_EQ(present(*line.hear(first, 202ms)), (std::vector<std::size_t>{1, 2, 3, 8}));
}

TEST(SrxlDecoder, AWordOfAFrameThatAPauseShowedIsAsOldAsItsBytes) {
    const Bytes first = plain_srxl(5, {1024, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF});
    Bytes behind_noise{0xA2};
    append(behind_noise,
           plain_srxl(5, {7 * 2048 + 100, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF}));
    for (const Duration at : {200ms, 201ms}) {
        Line line;
        line.hear(first, 0ms);
        EXPECT_FALSE(line.hear(behind_noise, at));
        DecodedFrame shown;
        ASSERT_TRUE(line.decoder().silence(shown));
        EXPECT_EQ(shown.channels.has(0), at == 200ms);
        EXPECT_TRUE(shown.channels.has(7));
        EXPECT_FALSE(line.decoder().silence(shown));
        EXPECT_EQ(line.hear(first, at + 200ms)->has(7), true);
        EXPECT_EQ(line.hear(first, at + 201ms)->has(7), false);
    }
}

TEST(SrxlDecoder, TakesNoOtherFirstByte) {
    for (unsigned first = 0; first <= 0xFF; ++first) {
        for (const std::size_t body : {std::size_t{16}, std::size_t{25}, std::size_t{33}}) {
            Bytes bytes(body, 0x08);
            bytes[0] = static_cast<std::uint8_t>(first);
            bytes = reference::plain_srxl_checked(bytes);
            SrxlDecoder decoder;
            EXPECT_EQ(all_frames(decoder, bytes).size(),
                      reference::plain_srxl_length(bytes[0]) == bytes.size() ? 1U : 0U)
                << first << " " << body;
        }
    }
}

TEST(SrxlDecoder, DetailsAreThoseOfTheLatestFrame) {
    Line line;
    EXPECT_TRUE(line.decoder().details().empty());
    const auto values = [&](std::size_t at) {
        const FrameDetail& detail = line.decoder().details()[at];
        return std::vector<std::uint16_t>(detail.values.begin(), detail.values.end());
    };
    line.hear(from_hex(kVersion1), 0ms);
    ASSERT_EQ(line.decoder().details().size(), 2U);
    EXPECT_EQ(line.decoder().details()[0].name, "version");
    EXPECT_EQ(values(0), std::vector<std::uint16_t>{1});
    EXPECT_EQ(line.decoder().details()[1].name, "raw");
    std::vector<std::uint16_t> raw(12, 2048);
    raw[0] = 0;
    raw[2] = 4095;
    EXPECT_EQ(values(1), raw);
    line.hear(from_hex(kVersion5), 14ms);
    EXPECT_EQ(values(0), std::vector<std::uint16_t>{5});
    EXPECT_EQ(values(1),
              (std::vector<std::uint16_t>{0x0C04, 0x2F6C, 0x10B4, 0x2616, 0x3401, 0x0476, 0x1C40}));
}

ChannelFrame good_frame() {
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    return frame;
}

Bytes encoded(const ChannelFrame& frame) {
    SrxlEncoder encoder;
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder.write(frame, wire, Line::kStart);
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

TEST(SrxlEncoder, WritesTheFrameOfTheSource) {
    ChannelFrame frame = good_frame();
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        frame.set(channel, kCentrePulse);
    }
    frame.set(0, Pulse::from_microseconds(800));
    frame.set(2, Pulse::from_microseconds(2200));
    EXPECT_EQ(encoded(frame), from_hex(kVersion2));
}

TEST(SrxlEncoder, EveryChannelHasTheNearestRawValue) {
    for (std::int32_t eighths = 6000; eighths <= 18000; ++eighths) {
        ChannelFrame frame = good_frame();
        for (std::int32_t channel = 0; channel < 16; ++channel) {
            frame.set(static_cast<std::size_t>(channel),
                      Pulse::from_eighths(eighths + 37 * channel));
        }
        const auto frames = reference::plain_srxl_frames(encoded(frame));
        ASSERT_EQ(frames.size(), 1U);
        ASSERT_EQ(frames[0].version(), 2U);
        for (std::size_t channel = 0; channel < 16; ++channel) {
            const double us = frame.channel(channel)->microseconds();
            const double raw = std::floor((us - 800) * 4096 / 1400 + 0.5);
            ASSERT_EQ(frames[0].word(1 + 2 * channel), std::clamp(raw, 0.0, 4095.0)) << us;
        }
    }
}

TEST(SrxlEncoder, WritesEveryRawValueOfEveryChannel) {
    SrxlDecoder decoder;
    for (unsigned raw = 0; raw <= 4095; ++raw) {
        std::vector<unsigned> words(16);
        for (unsigned i = 0; i < words.size(); ++i) {
            words[i] = (raw + 1001 * i) % 4096;
        }
        const Bytes bytes = plain_srxl(2, words);
        const auto frames = feed(decoder, bytes);
        ASSERT_EQ(frames.size(), 1U);
        ASSERT_EQ(encoded(frames[0].channels), bytes);
    }
}

TEST(SrxlEncoder, LimitsPulsesBeyondTheEndsAndCentresAbsentChannels) {
    ChannelFrame frame = good_frame();
    frame.set(1, Pulse::from_eighths(-32768));
    frame.set(2, Pulse::from_eighths(32767));
    std::vector<unsigned> words(16, 2048);
    words[1] = 0;
    words[2] = 4095;
    EXPECT_EQ(encoded(frame), plain_srxl(2, words));
    SrxlEncoder encoder;
    EXPECT_EQ(encoder.needed_channels(frame), 0xFFFFU);
}

TEST(SrxlEncoder, IsSilentInFailsafe) {
    SrxlEncoder encoder;
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    EXPECT_EQ(encoder.write_silence(wire, Line::kStart), 0U);
}

TEST(Srxl, IsInTheRegistryAndHeardByDoctor) {
    EXPECT_EQ(find_protocol("srxl"), &kSrxlProtocol);
    for (const auto& [hex, channels] :
         {std::pair(kVersion1, 12U), std::pair(kVersion2, 16U), std::pair(kVersion5, 7U)}) {
        const doctor::LineStory story = story_of(kSrxlProtocol, {from_hex(hex)}, 14ms);
        EXPECT_EQ(story.protocol, "srxl");
        EXPECT_EQ(story.channels, channels);
        EXPECT_EQ(story.period, std::optional<Duration>(14ms));
    }
}

}  // namespace
}  // namespace tribus::test::srxl_test
