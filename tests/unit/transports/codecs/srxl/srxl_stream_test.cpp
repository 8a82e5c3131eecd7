#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_srxl.h"
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

std::vector<DecodedFrame> all_frames(SrxlDecoder& decoder, const Bytes& bytes, Split split) {
    auto frames = feed(decoder, bytes, split);
    for (DecodedFrame late; decoder.silence(late);) {
        frames.push_back(late);
    }
    return frames;
}

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
        const Bytes good = from_hex(hex);
        for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
            Bytes bytes = good;
            bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
            append(bytes, good);
            for (const Split split : {kOneRead, kByteByByte}) {
                SrxlDecoder decoder;
                const auto frames = all_frames(decoder, bytes, split);
                ASSERT_EQ(frames.size(), 1U) << bit;
                EXPECT_EQ(frames[0].first_byte, good.size()) << bit;
            }
        }
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

TEST(SrxlStream, AfterAByteLostAddedOrChangedAnywhereEveryLaterFrameIsRead) {
    const FrameStream stream = mixed_stream();
    for (const FaultKind kind :
         {FaultKind::lost, FaultKind::added, FaultKind::replaced, FaultKind::damaged}) {
        for (std::size_t position = 0; position < stream.bytes.size(); ++position) {
            for (const std::uint8_t value : Bytes{0x00, 0xA1, 0xA2, 0xA5, 0xFF}) {
                for (const Split split : {kOneRead, kByteByByte, Split{.longest = 9, .seed = 3}}) {
                    const Fault fault{kind, position, value};
                    SrxlDecoder decoder;
                    auto frames = feed(decoder, stream.bytes, fault, split);
                    for (DecodedFrame late; decoder.silence(late);) {
                        frames.push_back(late);
                    }
                    std::vector<std::size_t> starts;
                    for (const DecodedFrame& frame : frames) {
                        starts.push_back(frame.first_byte);
                    }
                    for (std::size_t i = 0; i < stream.starts.size(); ++i) {
                        if (stream.starts[i] > position) {
                            EXPECT_EQ(std::ranges::count(starts, stream.shifted_start(i, fault)), 1)
                                << fault << " frame " << i;
                        }
                    }
                    if (kind != FaultKind::damaged) {
                        expect_as_plain(with_fault(stream.bytes, fault), split);
                    }
                }
            }
        }
    }
}

TEST(SrxlStream, IsTheSameHoweverTheStreamIsCutIntoReads) {
    const FrameStream stream = mixed_stream();
    SrxlDecoder whole;
    const auto expected = feed(whole, stream.bytes);
    ASSERT_EQ(expected.size(), stream.starts.size());
    for (std::size_t cut = 0; cut <= stream.bytes.size(); ++cut) {
        SrxlDecoder decoder;
        const auto all = std::span<const std::uint8_t>(stream.bytes);
        auto frames = feed(decoder, all.first(cut));
        feed_into(frames, decoder, all.subspan(cut));
        EXPECT_TRUE(same_frames(frames, expected)) << cut;
    }
    for (std::size_t longest = 1; longest < 60; ++longest) {
        SrxlDecoder decoder;
        EXPECT_TRUE(same_frames(feed(decoder, stream.bytes, {.longest = longest}), expected));
    }
}

TEST(SrxlStream, FindsAFrameBehindAnyFalseBeginning) {
    for (const std::string_view cut_frame : {kVersion1, kVersion2, kVersion5}) {
        for (const std::string_view next : {kVersion1, kVersion2, kVersion5}) {
            for (std::size_t cut = 1; cut < cut_frame.size() / 2; ++cut) {
                Bytes bytes = from_hex(cut_frame);
                bytes.resize(cut);
                append(bytes, from_hex(next));
                for (const Split split : {kOneRead, kByteByByte}) {
                    SrxlDecoder decoder;
                    const auto frames = all_frames(decoder, bytes, split);
                    ASSERT_EQ(frames.size(), 1U) << cut;
                    EXPECT_EQ(frames[0].first_byte, cut);
                }
            }
        }
    }
}

TEST(SrxlStream, APauseCutsAnUnfinishedFrameOff) {
    const Bytes bytes = from_hex(kVersion2);
    for (std::size_t cut = 1; cut < bytes.size(); ++cut) {
        SrxlDecoder decoder;
        const auto all = std::span<const std::uint8_t>(bytes);
        EXPECT_TRUE(feed(decoder, all.first(cut)).empty());
        DecodedFrame frame;
        EXPECT_FALSE(decoder.silence(frame));
        EXPECT_EQ(decoder.waiting(), 0U);
        EXPECT_TRUE(feed(decoder, all.subspan(cut)).empty()) << cut;
        EXPECT_EQ(feed(decoder, bytes).size(), 1U) << cut;
    }
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
