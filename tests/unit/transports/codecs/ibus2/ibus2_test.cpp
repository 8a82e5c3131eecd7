#include "transports/codecs/ibus2/ibus2.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "app/doctor/line_judge.h"
#include "tests/reference/plain_ibus2.h"
#include "tests/support/streams.h"
#include "transports/registry/registry.h"

namespace tribus::test::ibus2_test {
namespace {

using namespace std::chrono_literals;
using namespace reference;
using Types = std::vector<unsigned>;

// Captured from a FTr8B: ArduPilot, AP_IBus2/examples/captures.
constexpr std::string_view kCaptured18 =
    "001D07F8770080970F00000000C0000000000000000000000000003028";
constexpr std::string_view kCaptured8 = "000F07F96F00DA990F000000000035";
constexpr std::string_view kCommand = "05000000000000000000000000000000000000007D";
constexpr std::string_view kReply = "06F8100300000000000000000000000000000000A3";
/// 11 bits with a step of 1 us, as in the captures.
constexpr unsigned kUsualType = 0x1B;

const std::vector<std::optional<double>> kValues18{1492, 1514, 988,  1447, 1500, 1500,
                                                   1500, 988,  1500, 1500, 1500, 1500,
                                                   1500, 1500, 1500, 1500, 1500, 988};
const std::vector<std::optional<double>> kValues8{1493, 1513, 1348, 1448, 1500, 1500, 1500, 1500};

std::vector<std::optional<double>> microseconds(const ChannelFrame& frame, std::size_t count) {
    std::vector<std::optional<double>> values;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        const auto pulse = frame.channel(channel);
        if (channel < count) {
            values.push_back(pulse ? std::optional(pulse->microseconds()) : std::nullopt);
        } else {
            EXPECT_FALSE(pulse) << channel;
        }
        if (!pulse) {
            EXPECT_EQ(frame.pulses()[channel], Pulse{});
        }
    }
    return values;
}

std::vector<DecodedFrame> all_of(Ibus2Decoder& decoder, const Bytes& bytes,
                                 Split split = kOneRead) {
    auto frames = feed(decoder, bytes, split);
    for (DecodedFrame late; decoder.silence(late);) {
        frames.push_back(late);
    }
    return frames;
}

/// The channels of one frame after a key, alone in a read and byte by byte.
ChannelFrame read_with(const Types& types, const Bytes& channels) {
    Ibus2Decoder at_once;
    Ibus2Decoder in_bytes;
    feed(at_once, plain_ibus2_key(types));
    feed(in_bytes, plain_ibus2_key(types), kByteByByte);
    const auto frames = feed(at_once, channels);
    const auto same = feed(in_bytes, channels, kByteByByte);
    EXPECT_EQ(frames.size(), 1U);
    EXPECT_EQ(same.size(), 1U);
    if (frames.empty() || same.empty()) {
        return {};
    }
    EXPECT_TRUE(frames[0].channels.same_content(same[0].channels));
    EXPECT_EQ(frames[0].first_byte, same[0].first_byte);
    EXPECT_EQ(frames[0].length, same[0].length);
    EXPECT_EQ(at_once.skipped_bytes() + in_bytes.skipped_bytes(), 0U);
    return frames[0].channels;
}

/// A line as a receiver drives it, four times: channels, a command, its reply.
Bytes four_cycles() {
    Bytes bytes;
    for (int i = 0; i < 4; ++i) {
        append(bytes, plain_ibus2_channels(Types(8, kUsualType),
                                           {-8 - i, 14, -512, 511, 300, 0, 1, 2 + i}));
        append(bytes, from_hex(kCommand));
        append(bytes, from_hex(kReply));
    }
    return bytes;
}

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

TEST(Ibus2Decoder, ReadsEveryValueOfEveryType) {
    for (unsigned type = 0; type < 32; ++type) {
        const unsigned bits = type & 0x0FU;
        const auto step = plain_ibus2_steps().find(type);
        for (unsigned raw = 0; raw < 1U << bits; ++raw) {
            // A channel before it, so that it does not begin with a byte.
            const Types types{kUsualType, type, kUsualType};
            const ChannelFrame frame =
                read_with(types, plain_ibus2_channels(types, {-300, static_cast<int>(raw), 300}));
            ASSERT_EQ(frame.channel(0)->microseconds(), 1200) << type;
            ASSERT_EQ(frame.channel(2)->microseconds(), 1800) << type;
            const int sign = bits == 0 ? 0 : 1 << (bits - 1);
            const int value = static_cast<int>(raw) >= sign ? static_cast<int>(raw) - 2 * sign
                                                            : static_cast<int>(raw);
            const bool special = value == -sign || (bits >= 6 && value == -sign + 1);
            if (step == plain_ibus2_steps().end() || special) {
                ASSERT_FALSE(frame.has(1)) << type << " " << raw;
                continue;
            }
            ASSERT_EQ(frame.channel(1)->microseconds(),
                      std::clamp(1500 + value * step->second, 750.0, 2250.0))
                << type << " " << raw;
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

TEST(Ibus2Decoder, PassesOverFailsafeValuesCommandsAndReplies) {
    for (const Split split : {kOneRead, kByteByByte}) {
        Ibus2Decoder decoder;
        Bytes bytes = plain_ibus2_key(Types(8, kUsualType));
        append(bytes, four_cycles());
        append(bytes, plain_ibus2_to_all(0x08, std::vector<std::uint8_t>(11, 0x55)));
        const auto frames = all_of(decoder, bytes, split);
        ASSERT_EQ(frames.size(), 4U);
        EXPECT_TRUE(frames[3].channels.has_first(8));
        EXPECT_EQ(decoder.skipped_bytes(), 0U);
        EXPECT_EQ(count_of(decoder, "checksum"), 0U);
    }
}

TEST(Ibus2Decoder, TakesNoOtherFirstByteAndLength) {
    for (unsigned first = 0; first <= 0xFF; ++first) {
        for (std::size_t length = 2; length <= 60; ++length) {
            Bytes bytes(length - 1, 0x07);
            bytes[0] = static_cast<std::uint8_t>(first);
            if (length >= 3) {
                bytes[1] = static_cast<std::uint8_t>(length);
            }
            bytes = plain_ibus2_checked(bytes);
            Ibus2Decoder decoder;
            all_of(decoder, bytes);
            const bool to_all =
                first % 4 == 0 && first / 4 % 16 <= 2 && length >= 4 && length <= 37;
            const bool to_one =
                (first % 4 == 1 || first % 4 == 2) && first / 4 <= 4 && length == 21;
            ASSERT_EQ(decoder.skipped_bytes() == 0, to_all || to_one) << first << " " << length;
        }
    }
}

TEST(Ibus2Decoder, RefusesEachFlippedBit) {
    for (const Bytes& good : {from_hex(kCaptured18), from_hex(kCaptured8)}) {
        for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
            Bytes bytes = good;
            bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
            for (const Split split : {kOneRead, kByteByByte}) {
                Ibus2Decoder decoder;
                feed(decoder, plain_ibus2_key(Types(good.size() == 29 ? 18 : 8, kUsualType)));
                for (const DecodedFrame& frame : all_of(decoder, bytes, split)) {
                    EXPECT_FALSE(frame.channels.has_any()) << bit;
                }
            }
        }
    }
}

TEST(Ibus2Decoder, AKeyWithAFlippedBitIsNone) {
    const Bytes good = plain_ibus2_key(Types(8, kUsualType));
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
        Bytes bytes = good;
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
        append(bytes, from_hex(kCaptured8));
        append(bytes, from_hex(kCaptured8));
        Ibus2Decoder decoder;
        const auto frames = all_of(decoder, bytes);
        ASSERT_GE(frames.size(), 1U) << bit;
        for (const DecodedFrame& frame : frames) {
            EXPECT_FALSE(frame.channels.has_any()) << bit;
        }
    }
}

TEST(Ibus2Decoder, LosesOneFrameAtMostByAByteThatIsLostOrAddedAnywhere) {
    const Bytes key = plain_ibus2_key(Types(8, kUsualType));
    const Bytes good = four_cycles();
    std::size_t hurt = 0;
    std::size_t cases = 0;
    for (std::size_t at = 0; at < good.size(); ++at) {
        std::vector<Fault> faults{{FaultKind::lost, at}, {FaultKind::damaged, at}};
        for (const std::uint8_t value : Bytes{0x00, 0x05, 0x06, 0x07, 0x0F, 0x25, 0xFF}) {
            faults.push_back({FaultKind::added, at, value});
        }
        for (const Fault& fault : faults) {
            for (const Split split : {kOneRead, kByteByByte}) {
                Ibus2Decoder decoder;
                feed(decoder, key);
                auto frames = feed(decoder, good, fault, split);
                for (DecodedFrame late; decoder.silence(late);) {
                    frames.push_back(late);
                }
                const auto whole = std::ranges::count_if(
                    frames, [](const DecodedFrame& frame) { return frame.channels.has_first(8); });
                EXPECT_GE(whole, 3) << fault;
                EXPECT_LE(whole, 4) << fault;
                hurt += whole == 3 ? 1U : 0U;
                ++cases;
            }
        }
    }
    EXPECT_LT(hurt, cases / 2);
}

TEST(Ibus2Decoder, FindsAFrameBehindAnyFalseBeginning) {
    const Bytes key = plain_ibus2_key(Types(8, kUsualType));
    const Bytes whole = from_hex(kCaptured8);
    for (std::size_t cut = 1; cut < whole.size(); ++cut) {
        Bytes bytes = key;
        append(bytes, std::span(whole).first(cut));
        append(bytes, whole);
        for (const Split split : {kOneRead, kByteByByte}) {
            Ibus2Decoder decoder;
            const auto frames = all_of(decoder, bytes, split);
            ASSERT_EQ(frames.size(), 1U) << cut;
            EXPECT_EQ(frames[0].first_byte, key.size() + cut);
        }
    }
}

TEST(Ibus2Decoder, FindsAFrameInsideABadOneAndNoneInsideAGoodOne) {
    Bytes inside = from_hex(kCaptured8);
    inside.resize(19);
    Bytes outer{0x05};
    append(outer, inside);
    const Bytes good = plain_ibus2_checked(outer);
    Bytes bad = good;
    bad.back() = static_cast<std::uint8_t>(bad.back() ^ 0x10U);
    Ibus2Decoder in_good;
    EXPECT_TRUE(all_of(in_good, good).empty());
    Ibus2Decoder in_bad;
    const auto frames = all_of(in_bad, bad);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].first_byte, 1U);
    EXPECT_GE(count_of(in_bad, "checksum"), 1U);
}

TEST(Ibus2Decoder, APauseEndsAnIncompleteFrame) {
    const Bytes whole = from_hex(kCaptured8);
    for (std::size_t cut = 1; cut < whole.size(); ++cut) {
        Ibus2Decoder decoder;
        EXPECT_TRUE(feed(decoder, std::span(whole).first(cut)).empty());
        DecodedFrame late;
        EXPECT_FALSE(decoder.silence(late));
        EXPECT_TRUE(all_of(decoder, {whole.begin() + static_cast<std::ptrdiff_t>(cut), whole.end()})
                        .empty())
            << cut;
    }
}

TEST(Ibus2Decoder, FindsTheSameHoweverTheStreamIsCutIntoReads) {
    Bytes bytes = plain_ibus2_key(Types(8, kUsualType));
    append(bytes, four_cycles());
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
        Ibus2Decoder decoder;
        std::vector<DecodedFrame> frames;
        feed_into(frames, decoder, std::span(bytes).first(cut));
        feed_into(frames, decoder, std::span(bytes).subspan(cut));
        ASSERT_EQ(frames.size(), 4U) << cut;
        ASSERT_TRUE(frames[0].channels.has_first(8));
    }
}

/// A line of all kinds of frames, with noise.
Bytes random_line(Random& random) {
    constexpr std::array<std::uint8_t, 8> kLikely{0x00, 0x04, 0x05, 0x06, 0x07, 0x0F, 0x18, 0xC0};
    Bytes bytes;
    Types types;
    while (bytes.size() < 400) {
        switch (random.below(7)) {
            case 0:
                bytes.push_back(random.byte());
                break;
            case 1:
                bytes.push_back(kLikely[random.below(kLikely.size())]);
                break;
            case 2:
                append(bytes, from_hex(kReply));
                break;
            case 3:
                types.resize(random.below(20));
                for (unsigned& type : types) {
                    type = random.below(3) == 0 ? random.below(32) : kUsualType;
                }
                append(bytes, plain_ibus2_key(types));
                break;
            default: {
                std::vector<int> values(types.size());
                for (int& value : values) {
                    value = static_cast<int>(random());
                }
                Bytes channels = plain_ibus2_channels(
                    types, values, static_cast<std::uint8_t>(random.below(4) << 6U));
                if (channels.size() <= 37) {
                    append(bytes, channels);
                }
            }
        }
    }
    return bytes;
}

TEST(Ibus2Decoder, FindsWhatThePlainFormFindsOnAnyLine) {
    std::size_t channels_seen = 0;
    for (std::uint32_t seed = 1; seed <= 800; ++seed) {
        Random random(seed);
        Bytes bytes = random_line(random);
        for (std::uint32_t fault = 0; fault < seed % 4; ++fault) {
            bytes[random.below(400)] = random.byte();
        }
        Ibus2Decoder decoder;
        const auto frames = all_of(decoder, bytes, {.longest = 40, .seed = seed});
        const auto plain = PlainIbus2().frames_of(bytes);
        ASSERT_EQ(frames.size(), plain.size()) << seed;
        for (std::size_t i = 0; i < frames.size(); ++i) {
            ASSERT_EQ(frames[i].first_byte, plain[i].at) << seed;
            ASSERT_EQ(frames[i].length, plain[i].length) << seed;
            ASSERT_EQ(frames[i].channels.frame_lost, plain[i].frame_lost) << seed;
            ASSERT_EQ(frames[i].channels.failsafe, plain[i].failsafe) << seed;
            const auto us = microseconds(frames[i].channels, kChannelCount);
            for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
                ASSERT_EQ(us[channel], plain[i].us[channel]) << seed << " " << channel;
                channels_seen += us[channel] ? 1U : 0U;
            }
        }
    }
    EXPECT_GT(channels_seen, 10000U);
}

TEST(Ibus2, IsInTheRegistryAndHeardByDoctor) {
    EXPECT_EQ(find_protocol("ibus2"), &kIbus2Protocol);
    doctor::Heard heard{.line = kIbus2Protocol.line, .listened = 1s, .bursts = {}};
    for (int i = 0; i < 100; ++i) {
        const Bytes bytes = i == 0 ? plain_ibus2_key(Types(18, kUsualType)) : from_hex(kCaptured18);
        heard.bursts.push_back(
            {.start = i * 6ms, .bytes = bytes, .damaged = std::vector<bool>(bytes.size())});
    }
    const doctor::LineStory story = doctor::judge_line(std::span(&heard, 1));
    EXPECT_EQ(story.protocol, "ibus2");
    EXPECT_EQ(story.channels, 18U);
    EXPECT_EQ(story.period, std::optional<Duration>(6ms));
}

}  // namespace
}  // namespace tribus::test::ibus2_test
