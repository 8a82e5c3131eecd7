#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_ghst.h"
#include "tests/support/stream_rules.h"
#include "tests/support/streams.h"
#include "transports/codecs/ghst/ghst.h"

/// Faults on the line, and how a stream is cut into reads.
namespace tribus::test::ghst_stream_test {
namespace {

using reference::plain_ghst;
using reference::plain_ghst_payload;

// Computed from Betaflight's ghst_protocol.h.
constexpr std::string_view kStatistics = "820C33000880000880643C0514E3";
// ArduPilot, test_ghst_resync.cpp, make_frame of 1 and 2.
constexpr std::string_view kFirst = "820C30255442255442747576776C";
constexpr std::string_view kSecond = "820C304AA4444AA4447B7C7D7E4F";

Bytes frame_of(std::uint8_t type, unsigned fine, unsigned coarse) {
    return plain_ghst(
        type, plain_ghst_payload({fine, fine, fine, fine}, {coarse, coarse, coarse, coarse}));
}

/// Compares places and channels with those of the plain form on the same stream.
void expect_as_plain(const Bytes& bytes, Split split) {
    GhstDecoder decoder;
    const auto frames = all_frames(decoder, bytes, split);
    reference::PlainGhstChannels plain;
    std::size_t at = 0;
    for (const auto& expected : reference::plain_ghst_frames(bytes)) {
        if (!expected.has_channels()) {
            continue;
        }
        ASSERT_LT(at, frames.size());
        ASSERT_EQ(frames[at].first_byte, expected.at);
        ASSERT_EQ(frames[at].length, 14U);
        const auto values = plain.take(expected, 0);
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            const auto pulse = frames[at].channels.channel(channel);
            const auto value = channel < 16 ? values[channel] : std::nullopt;
            ASSERT_EQ(pulse.has_value(), value.has_value()) << channel;
            ASSERT_EQ(pulse ? pulse->microseconds() : 0, value.value_or(0)) << channel;
        }
        ++at;
    }
    EXPECT_EQ(at, frames.size());
}

// ArduPilot, test_ghst_resync.cpp, short_rc_frame_rejected.
TEST(GhstStream, AShortFrameInsideOfADamagedOneIsNone) {
    Bytes bytes = from_hex("820C30255442255442820230F6");
    append(bytes, from_hex(kSecond));
    for (const Split split : {kOneRead, kByteByByte}) {
        GhstDecoder decoder;
        const auto frames = all_frames(decoder, bytes, split);
        ASSERT_EQ(frames.size(), 1U);
        EXPECT_EQ(frames[0].first_byte, 13U);
        EXPECT_EQ(frames[0].channels.channel(0)->microseconds(), 1262.5);
    }
}

TEST(GhstStream, RefusesEachFlippedBitAndReadsTheNextFrame) {
    expect_each_flipped_bit_is_refused(make<GhstDecoder>, from_hex(kFirst), from_hex(kSecond));
}

TEST(GhstStream, StatisticsWithAFlippedBitAreNone) {
    for (std::size_t bit = 0; bit < 8 * 14; ++bit) {
        Bytes bytes = from_hex(kStatistics);
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
        append(bytes, from_hex(kSecond));
        GhstDecoder decoder;
        EXPECT_EQ(all_frames(decoder, bytes).size(), 1U) << bit;
        EXPECT_EQ(decoder.radio_statistics(), nullptr) << bit;
    }
}

/// Bytes with a meaning for the decoder, and others.
constexpr std::array<std::uint8_t, 5> kValues{0x00, 0x0C, 0x30, 0x82, 0xFF};
constexpr std::array<std::uint8_t, 6> kTypes{0x30, 0x31, 0x32, 0x33, 0x11, 0x35};

/// Frames as ArduPilot's test makes them, of all types by turns.
FrameStream usual_stream() {
    FrameStream stream;
    for (unsigned i = 0; i < kTypes.size(); ++i) {
        stream.add_frame(frame_of(kTypes[i], 1024 + 37 * i, 100 + 7 * i));
    }
    return stream;
}

/// The same, with payloads full of beginnings: a check of eight bits cannot tell every false frame.
FrameStream mixed_stream() {
    FrameStream stream;
    for (unsigned i = 0; i < kTypes.size(); ++i) {
        const std::array<unsigned, 4> fine{0xC82, 0x820 + i, 0x30C, 4095 - 600 * i};
        stream.add_frame(
            plain_ghst(kTypes[i], plain_ghst_payload(fine, {0x82, 0x0C, kTypes[i], 0x82 - i})));
    }
    return stream;
}

TEST(GhstStream, AfterAByteLostAddedOrChangedAnywhereEveryLaterFrameIsRead) {
    expect_every_frame_behind_a_fault(make<GhstDecoder>, usual_stream(), kValues);
}

TEST(GhstStream, WithAFaultAnywhereInPayloadsFullOfBeginningsItFindsWhatThePlainFormFinds) {
    const FrameStream stream = mixed_stream();
    for_each_fault(stream, kValues, [&](const Fault& fault, Split split) {
        if (fault.kind != FaultKind::damaged) {
            expect_as_plain(with_fault(stream.bytes, fault), split);
        }
    });
}

TEST(GhstStream, IsTheSameHoweverTheStreamIsCutIntoReads) {
    const FrameStream stream = mixed_stream();
    expect_the_same_however_cut(make<GhstDecoder>, stream.bytes, stream.starts.size());
}

TEST(GhstStream, FindsAFrameBehindAnyFalseBeginning) {
    expect_a_frame_behind_every_cut_one(make<GhstDecoder>, from_hex(kFirst), from_hex(kSecond));
}

TEST(GhstStream, APauseCutsAnUnfinishedFrameOff) {
    expect_a_pause_ends_a_frame(make<GhstDecoder>, from_hex(kFirst), from_hex(kSecond));
}

TEST(GhstStream, FindsWhatThePlainFormFindsOnAnyLine) {
    for (std::uint32_t seed = 1; seed <= 400; ++seed) {
        Random random(seed);
        Bytes bytes;
        while (bytes.size() < 400) {
            switch (random.below(6)) {
                case 0:
                    bytes.push_back(random.byte());
                    break;
                case 1:
                    bytes.push_back(0x82);
                    break;
                case 2:
                    append(bytes, Bytes{0x82, 0x0C});
                    break;
                default: {
                    Bytes payload(10);
                    for (std::uint8_t& byte : payload) {
                        byte = random.below(3) == 0 ? 0x82 : random.byte();
                    }
                    append(bytes,
                           plain_ghst(static_cast<std::uint8_t>(random.below(0x48)), payload));
                }
            }
        }
        for (std::uint32_t faults = seed % 4; faults > 0; --faults) {
            bytes[random.below(400)] = random.byte();
        }
        expect_as_plain(bytes, {.longest = 40, .seed = seed});
        expect_as_plain(bytes, kOneRead);
        GhstDecoder decoder;
        expect_no_frame_over_damage(decoder, bytes, random, 30);
    }
}

}  // namespace
}  // namespace tribus::test::ghst_stream_test
