#include "transports/codecs/ibus2/ibus2.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/heard_line.h"
#include "tests/unit/transports/codecs/ibus2/ibus2_frames.h"
#include "transports/registry/registry.h"

namespace tribus::test::ibus2_test {
namespace {

using namespace std::chrono_literals;
using namespace ibus2_frames;

TEST(Ibus2Decoder, ReadsCapturedChannelsWithAKey) {
    const ChannelFrame eighteen = read_with(Types(18, kUsualType), from_hex(kCaptured18));
    EXPECT_EQ(microseconds(eighteen, 18), kValues18);
    EXPECT_TRUE(eighteen.good());
    const ChannelFrame eight = read_with(Types(8, kUsualType), from_hex(kCaptured8));
    EXPECT_EQ(microseconds(eight, 8), kValues8);
}

TEST(Ibus2Decoder, BeforeAKeyAFrameHasNoChannels) {
    Ibus2Decoder decoder;
    const auto frames = feed(decoder, from_hex(kCaptured18));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_FALSE(frames[0].channels.has_any());
    EXPECT_TRUE(frames[0].channels.good());
    EXPECT_TRUE(decoder.details().empty());
}

TEST(Ibus2Decoder, ReadsEveryValueOfEveryChannelWhereAllAreAlike) {
    for (const unsigned type : {0x0BU, 0x1BU}) {
        for (const std::size_t count : {1U, 8U, 15U, 16U, 17U, 18U}) {
            const Types types(count, type);
            for (int start = -1024; start < 1024; start += 31) {
                std::vector<int> values(count);
                std::vector<std::optional<double>> expected(count);
                for (std::size_t i = 0; i < count; ++i) {
                    values[i] = (start + 1024 + 97 * static_cast<int>(i)) % 2048 - 1024;
                    if (values[i] > -1023) {
                        expected[i] = std::clamp(1500 + values[i] * plain_ibus2_steps().at(type),
                                                 750.0, 2250.0);
                    }
                }
                ASSERT_EQ(
                    microseconds(read_with(types, plain_ibus2_channels(types, values)), count),
                    expected)
                    << type << " " << count << " " << start;
            }
        }
    }
}

/// The pulse of a raw value; nothing if its type has no step, or if the value has a special
/// meaning.
std::optional<double> ibus2_microseconds(unsigned type, int raw) {
    const int bits = static_cast<int>(type & 0x0FU);
    const int sign = bits == 0 ? 0 : 1 << (bits - 1);
    const int value = raw >= sign ? raw - 2 * sign : raw;
    const auto step = plain_ibus2_steps().find(type);
    const bool special = value == -sign || (bits >= 6 && value == -sign + 1);
    if (step == plain_ibus2_steps().end() || special) {
        return std::nullopt;
    }
    return std::clamp(1500 + value * step->second, 750.0, 2250.0);
}

TEST(Ibus2Decoder, ReadsEveryValueOfEveryType) {
    constexpr unsigned kTogether = 8;
    for (unsigned type = 0; type < 32; ++type) {
        const unsigned values = 1U << (type & 0x0FU);
        for (unsigned first = 0; first < values; first += kTogether) {
            // Channels around them, so that the first does not begin with a byte.
            Types types(kTogether + 2, type);
            types.front() = types.back() = kUsualType;
            std::vector<int> raw{-300};
            std::vector<std::optional<double>> expected{1200};
            for (unsigned i = 0; i < kTogether; ++i) {
                raw.push_back(static_cast<int>((first + i) % values));
                expected.push_back(ibus2_microseconds(type, raw.back()));
            }
            raw.push_back(300);
            expected.emplace_back(1800);
            ASSERT_EQ(microseconds(read_with(types, plain_ibus2_channels(types, raw)), raw.size()),
                      expected)
                << type << " " << first;
        }
    }
}

TEST(Ibus2Decoder, KeepTheLastAndStopAreNoChannels) {
    const Types types(8, kUsualType);
    const ChannelFrame frame = read_with(
        types, plain_ibus2_channels(types, {1, -1024, 2, -1023, 3, -1022, 4, 1023}, 0x80));
    EXPECT_TRUE(frame.failsafe);
    EXPECT_EQ(microseconds(frame, 8),
              (std::vector<std::optional<double>>{1501, std::nullopt, 1502, std::nullopt, 1503, 750,
                                                  1504, 2250}));
}

TEST(Ibus2Decoder, AChannelThatIsKeptDoesNotKeepItsValue) {
    const Types types(8, kUsualType);
    Ibus2Decoder decoder;
    Bytes bytes = plain_ibus2_key(types);
    append(bytes, plain_ibus2_channels(types, std::vector<int>(8, 100)));
    append(bytes, plain_ibus2_channels(types, std::vector<int>(8, -1024)));
    const auto frames = feed(decoder, bytes);
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_TRUE(frames[0].channels.has_first(8));
    EXPECT_FALSE(frames[1].channels.has_any());
}

TEST(Ibus2Decoder, ReadsSyncLostAndFailsafe) {
    const Types types(8, kUsualType);
    for (const unsigned flags : {0x00U, 0x40U, 0x80U, 0xC0U}) {
        const ChannelFrame frame = read_with(
            types,
            plain_ibus2_channels(types, std::vector<int>(8), static_cast<std::uint8_t>(flags)));
        EXPECT_EQ(frame.frame_lost, (flags & 0x40U) != 0);
        EXPECT_EQ(frame.failsafe, (flags & 0x80U) != 0);
    }
}

TEST(Ibus2Decoder, AnotherKeyCountsFromThenOn) {
    Ibus2Decoder decoder;
    const Types wide(8, kUsualType);
    const Types narrow{0x1B, 0x1C, 0x0B, 0x02, 0x00, 0x19};
    Bytes bytes = plain_ibus2_key(wide);
    append(bytes, plain_ibus2_channels(wide, std::vector<int>(8, 100)));
    append(bytes, plain_ibus2_key(narrow));
    append(bytes, plain_ibus2_channels(narrow, {-100, 200, 300, -1, 0, 25}));
    append(bytes, plain_ibus2_channels(wide, std::vector<int>(8, 100)));
    const auto frames = feed(decoder, bytes, kByteByByte);
    ASSERT_EQ(frames.size(), 3U);
    EXPECT_EQ(microseconds(frames[0].channels, 8), std::vector<std::optional<double>>(8, 1600));
    EXPECT_EQ(microseconds(frames[1].channels, 6),
              (std::vector<std::optional<double>>{1400, 1600, 1650, 1000, std::nullopt, 1625}));
    EXPECT_FALSE(frames[2].channels.has_any()) << "of another length than the key says";
}

TEST(Ibus2Decoder, ChannelsOfEveryOtherLengthThanTheKeySaysAreNone) {
    const Types types(8, kUsualType);
    for (std::size_t bytes = 0; bytes <= 33; ++bytes) {
        const ChannelFrame frame =
            read_with(types, plain_ibus2_to_all(0x00, std::vector<std::uint8_t>(bytes, 0x11)));
        EXPECT_EQ(frame.has_any(), bytes == 11) << bytes;
    }
}

TEST(Ibus2Decoder, AKeyNeedsTheTypesOfAllChannels) {
    for (std::size_t size = 0; size <= 33; ++size) {
        std::vector<std::uint8_t> packed(size, 0x00);
        if (size > 0) {
            packed[0] = kUsualType;
        }
        Ibus2Decoder decoder;
        Bytes bytes = plain_ibus2_to_all(0x04, packed);
        append(bytes, plain_ibus2_channels({kUsualType}, {100}));
        const auto frames = feed(decoder, bytes);
        ASSERT_EQ(frames.size(), 1U);
        EXPECT_EQ(frames[0].channels.has_any(), size >= 20) << size;
    }
}

TEST(Ibus2Decoder, KeysAndChannelsForOneDeviceAreNotForAll) {
    const Types types(8, kUsualType);
    const Bytes key = plain_ibus2_key(types);
    const std::vector<std::uint8_t> packed(key.begin() + 3, key.end() - 1);
    const Bytes values = plain_ibus2_channels(types, std::vector<int>(8, 100));
    const std::vector<std::uint8_t> packed_values(values.begin() + 3, values.end() - 1);
    for (unsigned address = 0; address <= 0xFF; ++address) {
        const auto to = static_cast<std::uint8_t>(address);
        const bool all = (address & 0x07U) == 7 && address < 0x40;
        Ibus2Decoder by_key;
        Bytes bytes = plain_ibus2_to_all(0x04, packed, to);
        append(bytes, values);
        const auto frames = feed(by_key, bytes);
        ASSERT_EQ(frames.size(), 1U);
        EXPECT_EQ(frames[0].channels.has_any(), all) << address;
        Ibus2Decoder by_channels;
        bytes = key;
        append(bytes, plain_ibus2_to_all(0x00, packed_values, to));
        EXPECT_EQ(feed(by_channels, bytes).size(), all ? 1U : 0U) << address;
        EXPECT_EQ(by_channels.skipped_bytes(), 0U);
    }
}

TEST(Ibus2Decoder, AnUnpluggedLineTakesItsKeyAlong) {
    Ibus2Decoder decoder;
    feed(decoder, plain_ibus2_key(Types(8, kUsualType)));
    ASSERT_EQ(decoder.details().size(), 1U);
    EXPECT_EQ(decoder.details()[0].values[7], kUsualType);
    EXPECT_EQ(decoder.details()[0].values[8], 0);
    EXPECT_TRUE(feed(decoder, from_hex(kCaptured8)).at(0).channels.has_any());
    decoder.reset();
    EXPECT_FALSE(feed(decoder, from_hex(kCaptured8)).at(0).channels.has_any());
    EXPECT_TRUE(decoder.details().empty());
}

TEST(Ibus2, IsInTheRegistryAndHeardByDoctor) {
    EXPECT_EQ(find_protocol("ibus2"), &kIbus2Protocol);
    std::vector<Bytes> bursts(200, from_hex(kCaptured18));
    bursts[0] = plain_ibus2_key(Types(18, kUsualType));
    const doctor::LineStory story = story_of(kIbus2Protocol, bursts, 6ms);
    EXPECT_EQ(story.protocol, "ibus2");
    EXPECT_EQ(story.channels, 18U);
    EXPECT_EQ(story.period, std::optional<Duration>(6ms));
}

}  // namespace
}  // namespace tribus::test::ibus2_test
