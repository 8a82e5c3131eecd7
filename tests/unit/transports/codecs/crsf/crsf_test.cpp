#include "transports/codecs/crsf/crsf.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_crsf.h"
#include "tests/support/channel_bytes.h"
#include "tests/support/heard_line.h"
#include "tests/support/stream_rules.h"
#include "tests/support/streams.h"
#include "transports/registry/registry.h"

namespace tribus::test::crsf_test {
namespace {

using namespace std::chrono_literals;
using reference::plain_crsf;
using reference::plain_crsf_packed;
using Raw = std::array<std::uint16_t, 16>;

// Derived from TBS's text: all 992.
constexpr std::string_view kCentred = "C81816E0031FF8C0073EF0810F7CE0031FF8C0073EF0810F7CAD";
// A handset with arming mode "Switch" (EdgeTX crossfire.cpp): one byte more, address EE.
constexpr std::string_view kArmed = "EE1916E0031FF8C0073EF0810F7CE0031FF8C0073EF0810F7C019C";
// Betaflight, rx_crsf_unittest.cc: channels 5 to 8 of 11 bits.
constexpr std::string_view kSubset = "C809172400A0D9E9FF0FD1";
// EdgeTX, link statistics of a receiver without a transmitter.
constexpr std::string_view kNoLink = "000C1400000000FF0103000000F4";

Bytes statistics(std::uint8_t link_quality) {
    return plain_crsf(0xC8, 0x14, {60, 70, link_quality, 9, 1, 4, 3, 50, 99, 8});
}

Bytes channels_of(std::uint16_t raw) {
    Raw all{};
    all.fill(raw);
    return plain_crsf(0xC8, 0x16, plain_crsf_packed(all));
}

using Line = HeardLine<CrsfDecoder>;

TEST(CrsfDecoder, ReadsEveryRawValueOfEveryChannelExactly) {
    for (std::uint16_t raw = 0; raw <= 2047; ++raw) {
        Raw all{};
        for (std::size_t channel = 0; channel < all.size(); ++channel) {
            all[channel] = static_cast<std::uint16_t>((raw + 131 * channel) % 2048);
        }
        CrsfDecoder decoder;
        const auto frames = feed(decoder, plain_crsf(0xC8, 0x16, plain_crsf_packed(all)));
        ASSERT_EQ(frames.size(), 1U) << raw;
        for (std::size_t channel = 0; channel < all.size(); ++channel) {
            ASSERT_EQ(frames[0].channels.channel(channel)->eighths(),
                      (all[channel] - 992) * 5 + 12000)
                << raw << " " << channel;
        }
        EXPECT_FALSE(frames[0].channels.has(16));
        EXPECT_TRUE(frames[0].channels.good());
    }
}

TEST(CrsfDecoder, TakesChannelsFromEveryAddressOfTheListAndNoOther) {
    for (unsigned address = 0; address <= 0xFF; ++address) {
        CrsfDecoder decoder;
        const Bytes bytes =
            plain_crsf(static_cast<std::uint8_t>(address), 0x16, plain_crsf_packed({}));
        auto frames = feed(decoder, bytes);
        if (const auto last = decoder.finish()) {
            frames.push_back(*last);
        }
        const bool listed = address == 0x00 || address == 0xC8 || address == 0xEA ||
                            address == 0xEC || address == 0xEE;
        EXPECT_EQ(frames.size(), listed ? 1U : 0U) << address;
    }
}

TEST(CrsfDecoder, TakesALongerFrameOfChannels) {
    CrsfDecoder decoder;
    const auto frames = feed(decoder, from_hex(kArmed));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(pulses_of(frames[0].channels), std::vector<double>(16, 1500));
    EXPECT_EQ(frames[0].length, 27U);
}

TEST(CrsfDecoder, RefusesEachFlippedBitAndReadsTheNextFrame) {
    expect_each_flipped_bit_is_refused(make<CrsfDecoder>, from_hex(kCentred), channels_of(1500));
}

TEST(CrsfDecoder, FindsAFrameBehindAnyFalseBeginning) {
    expect_a_frame_behind_every_cut_one(make<CrsfDecoder>, from_hex(kCentred), channels_of(1500));
}

TEST(CrsfDecoder, APauseEndsAFrame) {
    expect_a_pause_ends_a_frame(make<CrsfDecoder>, from_hex(kCentred), channels_of(1500));
}

TEST(CrsfDecoder, FindsWhatThePlainFormFindsOnAnyLine) {
    for (std::uint32_t seed = 1; seed <= 400; ++seed) {
        Random random(seed);
        Bytes bytes;
        while (bytes.size() < 400) {
            switch (random.below(6)) {
                case 0:
                    bytes.push_back(random.byte());
                    break;
                case 1:
                    append(bytes, statistics(50));
                    break;
                case 2:
                    bytes.push_back(0xC8);
                    break;
                case 3:
                    append(bytes, plain_crsf(0xEA, 0x29, Bytes(random.below(60), 0xC8)));
                    break;
                default:
                    append(bytes, channels_of(static_cast<std::uint16_t>(random.below(2048))));
            }
        }
        if (seed % 2 == 0) {
            bytes[random.below(400)] = random.byte();
        }
        std::vector<std::size_t> expected;
        for (const auto& frame : reference::plain_crsf_frames(bytes)) {
            if (frame.type == 0x16) {
                expected.push_back(frame.at);
            }
        }
        CrsfDecoder decoder;
        std::vector<std::size_t> found;
        for (const DecodedFrame& frame :
             all_frames(decoder, bytes, {.longest = 40, .seed = seed})) {
            if (frame.channels.has_any()) {
                found.push_back(static_cast<std::size_t>(frame.first_byte));
            }
        }
        EXPECT_EQ(found, expected) << seed;
    }
}

TEST(CrsfDecoder, PassesOverEveryOtherTypeOfAnyLength) {
    for (unsigned type = 0; type <= 0xFF; ++type) {
        if (type == 0x14 || type == 0x16 || type == 0x17 || type == 0x1C) {
            continue;
        }
        for (std::size_t length = 0; length <= 60; length += 12) {
            Bytes bytes = plain_crsf(0xC8, static_cast<std::uint8_t>(type), Bytes(length, 0x16));
            append(bytes, channels_of(992));
            CrsfDecoder decoder;
            ASSERT_EQ(feed(decoder, bytes).size(), 1U) << type << " " << length;
            ASSERT_EQ(decoder.skipped_bytes(), 0U);
        }
    }
}

TEST(CrsfDecoder, ReadsASubset) {
    Line line;
    const auto frame = line.hear(from_hex(kSubset), 0ms);
    ASSERT_TRUE(frame);
    EXPECT_FALSE(frame->has(3));
    EXPECT_EQ(frame->channel(4), Pulse::from_eighths(988 * 8));
    EXPECT_EQ(frame->channel(5), Pulse::from_eighths(1398 * 8));
    EXPECT_EQ(frame->channel(6)->microseconds(), 1967.5);
    EXPECT_EQ(frame->channel(7)->microseconds(), 2011.5);
    EXPECT_FALSE(frame->has(8));
}

TEST(CrsfDecoder, ReadsEveryFinenessOfASubset) {
    for (unsigned fineness = 0; fineness < 4; ++fineness) {
        const unsigned bits = 10 + fineness;
        const unsigned greatest = (1U << bits) - 1;
        Bytes payload{static_cast<std::uint8_t>(fineness << 5U)};
        payload.resize(1 + (bits + 7) / 8, 0xFF);
        Line line;
        const auto frame = line.hear(plain_crsf(0xC8, 0x17, payload), 0ms);
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->channel(0)->eighths(),
                  988 * 8 + static_cast<std::int32_t>(greatest << (3 - fineness)));
    }
}

TEST(CrsfDecoder, ASubsetKeepsTheChannelsOfOthersForATenthOfASecond) {
    const Bytes first = plain_crsf(0xC8, 0x17, {0x00, 0x00, 0x02});   // channel 1, 10 bits: 512
    const Bytes second = plain_crsf(0xC8, 0x17, {0x01, 0x00, 0x02});  // channel 2
    Line line;
    line.hear(first, 0ms);
    const auto both = line.hear(second, 100ms);
    ASSERT_TRUE(both);
    EXPECT_EQ(pulses_of(*both), (std::vector<double>{1500, 1500}));
    const auto later = line.hear(second, 101ms);
    ASSERT_TRUE(later);
    EXPECT_FALSE(later->has(0));
    EXPECT_TRUE(later->has(1));
}

/// Between frames of 17 a frame of 16 is newer than what earlier ones said.
TEST(CrsfDecoder, ASubsetIsFilledFromTheNewestFrameOfEitherType) {
    const Bytes first = plain_crsf(0xC8, 0x17, {0x00, 0x00, 0x02});   // channel 1: 1500 us
    const Bytes second = plain_crsf(0xC8, 0x17, {0x01, 0x00, 0x02});  // channel 2: 1500 us
    Line line;
    line.hear(first, 0ms);
    line.hear(channels_of(192), 50ms);
    const auto filled = line.hear(second, 60ms);
    ASSERT_TRUE(filled);
    std::vector<double> pulses(16, 1000);
    pulses[1] = 1500;
    EXPECT_EQ(pulses_of(*filled), pulses);
    line.hear(first, 70ms);
    pulses[0] = 1500;
    EXPECT_EQ(pulses_of(*line.hear(second, 150ms)), pulses);
    EXPECT_EQ(pulses_of(*line.hear(second, 151ms)), (std::vector<double>{1500, 1500}));
}

/// All of them came with one read.
TEST(CrsfDecoder, ASubsetIsFilledInTheOrderOfTheFramesNotByTheirTime) {
    const Bytes first = plain_crsf(0xC8, 0x17, {0x00, 0x00, 0x02});   // channel 1: 1500 us
    const Bytes second = plain_crsf(0xC8, 0x17, {0x01, 0x00, 0x02});  // channel 2: 1500 us
    Line line;
    line.hear(first, 0ms);
    line.hear(channels_of(192), 0ms);
    EXPECT_EQ(line.hear(second, 0ms)->channel(0)->microseconds(), 1000);
    line.hear(first, 0ms);
    EXPECT_EQ(line.hear(second, 0ms)->channel(0)->microseconds(), 1500);
}

TEST(CrsfDecoder, ChannelsCarryTheLinkQualityOfStatisticsForASecond) {
    Line line;
    EXPECT_EQ(line.hear(channels_of(992), 0ms)->link_quality, kNoLinkQuality);
    EXPECT_FALSE(line.hear(statistics(87), 2ms));
    EXPECT_EQ(line.hear(channels_of(992), 4ms)->link_quality, 87);
    EXPECT_EQ(line.hear(channels_of(992), 1002ms)->link_quality, 87);
    EXPECT_EQ(line.hear(channels_of(992), 1003ms)->link_quality, kNoLinkQuality);
}

TEST(CrsfDecoder, ReadsStatistics) {
    Line line;
    line.hear(statistics(87), 2ms);
    const RadioStatistics* statistics = line.decoder().radio_statistics();
    ASSERT_TRUE(statistics);
    EXPECT_EQ(statistics->link_quality, 87);
    EXPECT_EQ(statistics->rssi_dbm, -70) << "of the antenna in use, the second";
    EXPECT_EQ(statistics->snr_db, 9);
    EXPECT_EQ(statistics->power_mw, 100);
    EXPECT_EQ(statistics->mode, 4);
}

TEST(CrsfDecoder, ReadsStatisticsOfEveryByte) {
    for (unsigned byte = 0; byte <= 0xFF; ++byte) {
        const auto value = static_cast<std::uint8_t>(byte);
        Line line;
        line.hear(plain_crsf(0xC8, 0x14, {value, 1, value, value, 0, value, value, 0, 0, 0}), 0ms);
        const RadioStatistics* statistics = line.decoder().radio_statistics();
        ASSERT_TRUE(statistics);
        EXPECT_EQ(statistics->rssi_dbm, -static_cast<int>(byte));
        EXPECT_EQ(statistics->link_quality, byte);
        EXPECT_EQ(statistics->snr_db,
                  byte < 128 ? static_cast<int>(byte) : static_cast<int>(byte) - 256);
        EXPECT_EQ(statistics->mode, byte);
        EXPECT_EQ(statistics->power_mw.has_value(), byte <= 8);
    }
}

TEST(CrsfDecoder, RawValuesAreTheDetailOfTheirOwnFrameOnly) {
    Line line;
    const auto names = [&] {
        std::vector<std::string_view> all;
        for (const FrameDetail& detail : line.decoder().details()) {
            all.push_back(detail.name);
        }
        return all;
    };
    line.hear(channels_of(992), 0ms);
    EXPECT_EQ(names(), std::vector<std::string_view>{"raw"});
    line.hear(from_hex(kSubset), 7ms);
    EXPECT_EQ(names(), std::vector<std::string_view>{});
    line.hear(channels_of(992), 14ms);
    line.hear(from_hex(kNoLink), 20ms);
    line.hear(from_hex(kNoLink), 21ms);
    EXPECT_EQ(names(), (std::vector<std::string_view>{"link_quality", "rssi_minus_dbm"}));
}

TEST(CrsfDecoder, StatisticsOfQualityZeroWithoutChannelsSinceTheLastAreFailsafe) {
    Line line;
    line.hear(channels_of(992), 0ms);
    EXPECT_FALSE(line.hear(from_hex(kNoLink), 10ms)) << "channels came just before";
    const auto lost = line.hear(from_hex(kNoLink), 11ms);
    ASSERT_TRUE(lost);
    EXPECT_TRUE(lost->failsafe);
    EXPECT_FALSE(lost->has_any());
    EXPECT_EQ(lost->link_quality, 0);
}

TEST(CrsfDecoder, StatisticsOfAGoodLinkWithoutChannelsAreAFrameWithoutChannels) {
    Line line;
    line.hear(channels_of(992), 0ms);
    for (const Duration at : {50ms, 150ms, 249ms}) {
        EXPECT_FALSE(line.hear(statistics(100), at)) << at / 1ms;
    }
    const auto frame = line.hear(statistics(100), 250ms);
    ASSERT_TRUE(frame);
    EXPECT_TRUE(frame->good());
    EXPECT_FALSE(frame->has_any());
    ASSERT_TRUE(line.hear(channels_of(992), 260ms)->has_any());
    EXPECT_FALSE(line.hear(statistics(100), 350ms));
}

Bytes encoded(CrsfEncoder& encoder, const ChannelFrame& frame, Duration at) {
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder.write(frame, wire, Line::kStart + at);
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

ChannelFrame all_at(Pulse pulse) {
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        frame.set(channel, pulse);
    }
    return frame;
}

TEST(CrsfEncoder, WritesEveryRawValueAndLimitsTheOthers) {
    CrsfEncoder encoder;
    for (std::uint16_t raw = 0; raw <= 2047; ++raw) {
        EXPECT_EQ(encoded(encoder, all_at(Pulse::from_eighths((raw - 992) * 5 + 12000)), 0ms),
                  channels_of(raw));
    }
    EXPECT_EQ(encoded(encoder, all_at(Pulse::from_eighths(0)), 0ms), channels_of(0));
    EXPECT_EQ(encoded(encoder, all_at(Pulse::from_eighths(32767)), 0ms), channels_of(2047));
}

TEST(CrsfEncoder, CentresAbsentChannels) {
    CrsfEncoder encoder;
    ChannelFrame none;
    none.frame_lost = false;
    none.failsafe = false;
    EXPECT_EQ(encoded(encoder, none, 0ms), from_hex(kCentred));
}

TEST(CrsfEncoder, ValuesThatAreHeldOrPresetHaveLinkQualityZero) {
    Bytes no_link = from_hex(kCentred);
    append(no_link, plain_crsf(0xC8, 0x14, Bytes(10)));
    for (const bool held : {true, false}) {
        CrsfEncoder encoder;
        ChannelFrame frame = all_at(kCentrePulse);
        frame.link_quality = 87;
        frame.frame_lost = held;
        frame.failsafe = !held;
        EXPECT_EQ(encoded(encoder, frame, 0ms), no_link) << held;
    }
}

TEST(CrsfEncoder, WritesTheLinkQualityTenTimesASecondAndNoneThatItDoesNotKnow) {
    CrsfEncoder encoder;
    ChannelFrame frame = all_at(kCentrePulse);
    EXPECT_EQ(encoded(encoder, frame, 0ms).size(), 26U);
    frame.link_quality = 73;
    Bytes with_statistics = from_hex(kCentred);
    append(with_statistics, plain_crsf(0xC8, 0x14, {0, 0, 73, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(encoded(encoder, frame, 7ms), with_statistics);
    EXPECT_EQ(encoded(encoder, frame, 106ms).size(), 26U);
    EXPECT_EQ(encoded(encoder, frame, 107ms), with_statistics);
}

TEST(CrsfEncoder, WhileSilentItWritesLinkQualityZeroTenTimesASecond) {
    CrsfEncoder encoder;
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const Bytes no_link = plain_crsf(0xC8, 0x14, Bytes(10));
    for (const Duration at : {0ms, 100ms, 205ms}) {
        const std::size_t length = encoder.write_silence(wire, Line::kStart + at);
        EXPECT_EQ(Bytes(wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)), no_link);
        EXPECT_EQ(encoder.write_silence(wire, Line::kStart + at + 99ms), 0U);
    }
}

TEST(Crsf, IsInTheRegistryAndHeardByDoctor) {
    EXPECT_EQ(find_protocol("crsf"), &kCrsfProtocol);
    std::vector<Bytes> bursts(5, from_hex(kCentred));
    append(bursts.back(), statistics(90));
    const doctor::LineStory story = story_of(kCrsfProtocol, bursts, 20ms);
    EXPECT_EQ(story.protocol, "crsf");
    EXPECT_EQ(story.channels, 16U);
    EXPECT_EQ(story.period, std::optional<Duration>(20ms));
}

}  // namespace
}  // namespace tribus::test::crsf_test
