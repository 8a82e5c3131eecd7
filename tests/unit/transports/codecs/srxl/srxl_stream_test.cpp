#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_srxl.h"
#include "tests/support/stream_rules.h"
#include "tests/support/streams.h"
#include "transports/codecs/srxl/srxl.h"

/// Faults on the line, and how a stream is cut into reads.
namespace tribus::test::srxl_stream_test {
namespace {

using reference::plain_srxl;

// Computed from the layout in ArduPilot's AP_RCProtocol_SRXL.cpp.
constexpr std::string_view kVersion1 = "A1000008000FFF0800080008000800080008000800080008002BF4";
constexpr std::string_view kVersion2 =
    "A2000008000FFF0800080008000800080008000800080008000800080008000800DA2E";
// ArduPilot, RCProtocolTest.cpp, srxl_bytes: a recording of an AR7700.
constexpr std::string_view kVersion5 = "A5030C042F6C10B42616340104761C40F53B";

/// Compares places, channels and flags with those of the plain form on the same stream.
void expect_as_plain(const Bytes& bytes, Split split) {
    SrxlDecoder decoder;
    const auto frames = all_frames(decoder, bytes, split);
    const auto expected = reference::plain_srxl_frames(bytes);
    reference::PlainSrxlChannels plain;
    ASSERT_EQ(frames.size(), expected.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
        ASSERT_EQ(frames[i].first_byte, expected[i].at);
        ASSERT_EQ(frames[i].length, expected[i].bytes.size());
        ASSERT_EQ(frames[i].channels.failsafe,
                  expected[i].version() == 5 && expected[i].bytes[1] / 2 % 2 == 0);
        const auto values = plain.take(expected[i], 0);
        for (std::size_t channel = 0; channel < values.size(); ++channel) {
            const auto pulse = frames[i].channels.channel(channel);
            ASSERT_EQ(pulse.has_value(), values[channel].has_value()) << channel;
            ASSERT_EQ(pulse ? pulse->microseconds() : 0, values[channel].value_or(0)) << channel;
        }
    }
}

TEST(SrxlStream, RefusesEachFlippedBitAndReadsTheNextFrame) {
    for (const std::string_view hex : {kVersion1, kVersion2, kVersion5}) {
        expect_each_flipped_bit_is_refused(make<SrxlDecoder>, from_hex(hex), from_hex(hex));
    }
}

/// Frames of all versions whose words are full of beginnings.
FrameStream mixed_stream() {
    FrameStream stream;
    const std::vector<unsigned> beginnings{0xA1A2, 0x0A5A, 0x0A1A, 0xA5A5, 0x0800, 0x00A2,
                                           0x0A5A, 0xA200, 0x0123, 0xA1A1, 0x0A2A, 0xA5A1,
                                           0x0777, 0xA2A2, 0x00A5, 0x0FA1};
    for (const unsigned version : {2U, 5U, 1U, 2U, 5U}) {
        const std::size_t count = version == 1 ? 12 : version == 2 ? 16 : 7;
        stream.add_frame(plain_srxl(
            version, {beginnings.begin(), beginnings.begin() + static_cast<std::ptrdiff_t>(count)},
            0xA2));
    }
    return stream;
}

/// First bytes of frames, and others.
constexpr std::array<std::uint8_t, 5> kValues{0x00, 0xA1, 0xA2, 0xA5, 0xFF};

TEST(SrxlStream, AfterAByteLostAddedOrChangedAnywhereEveryLaterFrameIsRead) {
    expect_every_frame_behind_a_fault(make<SrxlDecoder>, mixed_stream(), kValues);
}

TEST(SrxlStream, WithAFaultAnywhereItFindsWhatThePlainFormFinds) {
    const FrameStream stream = mixed_stream();
    for_each_fault(stream, kValues, [&](const Fault& fault, Split split) {
        if (fault.kind != FaultKind::damaged) {
            expect_as_plain(with_fault(stream.bytes, fault), split);
        }
    });
}

TEST(SrxlStream, IsTheSameHoweverTheStreamIsCutIntoReads) {
    const FrameStream stream = mixed_stream();
    expect_the_same_however_cut(make<SrxlDecoder>, stream.bytes, stream.starts.size());
}

TEST(SrxlStream, FindsAFrameBehindAnyFalseBeginning) {
    for (const std::string_view cut : {kVersion1, kVersion2, kVersion5}) {
        for (const std::string_view next : {kVersion1, kVersion2, kVersion5}) {
            expect_a_frame_behind_every_cut_one(make<SrxlDecoder>, from_hex(cut), from_hex(next));
        }
    }
}

TEST(SrxlStream, APauseCutsAnUnfinishedFrameOff) {
    expect_a_pause_ends_a_frame(make<SrxlDecoder>, from_hex(kVersion2), from_hex(kVersion2));
}

TEST(SrxlStream, FindsWhatThePlainFormFindsOnAnyLine) {
    constexpr std::array<std::uint8_t, 3> kFirstBytes{0xA1, 0xA2, 0xA5};
    for (std::uint32_t seed = 1; seed <= 400; ++seed) {
        Random random(seed);
        Bytes bytes;
        while (bytes.size() < 600) {
            const std::uint8_t first = kFirstBytes[random.below(3)];
            Bytes frame(reference::plain_srxl_length(first) - 2);
            for (std::uint8_t& byte : frame) {
                byte = random.below(4) == 0 ? kFirstBytes[random.below(3)] : random.byte();
            }
            frame[0] = first;
            const std::uint32_t kind = random.below(6);
            if (kind == 0) {
                bytes.push_back(random.byte());
            } else if (kind == 1) {
                bytes.push_back(first);
            } else {
                append(bytes, reference::plain_srxl_checked(frame));
            }
        }
        for (std::uint32_t faults = seed % 4; faults > 0; --faults) {
            bytes[random.below(600)] = random.byte();
        }
        expect_as_plain(bytes, {.longest = 40, .seed = seed});
        expect_as_plain(bytes, kOneRead);
        SrxlDecoder decoder;
        expect_no_frame_over_damage(decoder, bytes, random, 60);
    }
}

}  // namespace
}  // namespace tribus::test::srxl_stream_test
