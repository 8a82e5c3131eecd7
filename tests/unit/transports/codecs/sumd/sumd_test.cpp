#include "transports/codecs/sumd/sumd.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/channel_bytes.h"
#include "tests/support/heard_line.h"
#include "tests/support/stream_rules.h"
#include "tests/support/streams.h"
#include "transports/registry/registry.h"

namespace tribus::test::sumd_test {
namespace {

using namespace std::chrono_literals;

// ArduPilot, RCProtocolTest.cpp, sumd1.
constexpr std::string_view kEightChannels = "a801082f5031e821a02f50226022602ee02ee087c6";
// PX4's recording of a receiver, sumd_data.txt.
constexpr std::string_view kRecorded = "A8010C22742ED82EE02ED8226022603B60226022603B602EE02EE0F99B";
// Betaflight, rx_sumd_unittest.cc, failsafe: 8 x 1500 us.
constexpr std::string_view kFailsafe = "A881082EE02EE02EE02EE02EE02EE02EE02EE0F90F";

ChannelFrame decoded(std::string_view hex) {
    SumdDecoder decoder;
    const auto frames = feed(decoder, from_hex(hex));
    EXPECT_EQ(frames.size(), 1U) << hex;
    return frames.empty() ? ChannelFrame{} : frames.front().channels;
}

Bytes encoded(const ChannelFrame& frame, std::size_t channels) {
    SumdEncoder encoder(channels);
    return test::encoded(encoder, frame);
}

/// A frame of `count` words with a right check.
Bytes frame_of(std::uint8_t status, const std::vector<std::uint16_t>& words) {
    Bytes bytes{0xA8, status, static_cast<std::uint8_t>(words.size())};
    for (const std::uint16_t word : words) {
        bytes.push_back(static_cast<std::uint8_t>(word >> 8U));
        bytes.push_back(static_cast<std::uint8_t>(word));
    }
    unsigned crc = 0;
    for (const std::uint8_t byte : bytes) {
        crc ^= static_cast<unsigned>(byte) << 8U;
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc << 1U) ^ ((crc & 0x8000U) != 0 ? 0x11021U : 0U);
        }
    }
    bytes.push_back(static_cast<std::uint8_t>(crc >> 8U));
    bytes.push_back(static_cast<std::uint8_t>(crc));
    return bytes;
}

TEST(Sumd, ReadsChannelsInTheOrderOfTheWire) {
    EXPECT_EQ(pulses_of(decoded(kEightChannels)),
              (std::vector<double>{1514, 1597, 1076, 1514, 1100, 1100, 1500, 1500}));
    EXPECT_TRUE(decoded(kEightChannels).good());
}

TEST(Sumd, ReadsARecordedFrameToAnEighthOfAMicrosecond) {
    EXPECT_EQ(pulses_of(decoded(kRecorded)),
              (std::vector<double>{1102.5, 1499, 1500, 1499, 1100, 1100, 1900, 1100, 1100, 1900,
                                   1500, 1500}));
}

TEST(Sumd, ReadsFailsafe) {
    const ChannelFrame frame = decoded(kFailsafe);
    EXPECT_TRUE(frame.failsafe);
    EXPECT_FALSE(frame.frame_lost);
    EXPECT_EQ(pulses_of(frame), std::vector<double>(8, 1500));
}

TEST(Sumd, ReadsEveryNumberOfChannelsAndKeepsTheFirstEighteen) {
    for (std::size_t count = 1; count <= 32; ++count) {
        SumdDecoder decoder;
        const auto frames = feed(decoder, frame_of(0x03, std::vector<std::uint16_t>(count, 12000)));
        ASSERT_EQ(frames.size(), 1U) << count;
        EXPECT_EQ(frames[0].length, 5 + 2 * count);
        EXPECT_EQ(pulses_of(frames[0].channels),
                  std::vector<double>(std::min<std::size_t>(count, 18), 1500));
    }
}

TEST(Sumd, ReadsEveryWordExactlyAndZeroAsNoChannel) {
    for (unsigned word = 0; word <= 0x7FFF; ++word) {
        SumdDecoder decoder;
        const auto frames = feed(decoder, frame_of(0x01, {static_cast<std::uint16_t>(word)}));
        ASSERT_EQ(frames.size(), 1U);
        if (word == 0) {
            EXPECT_FALSE(frames[0].channels.has(0));
        } else {
            ASSERT_EQ(frames[0].channels.channel(0)->eighths(), static_cast<int>(word));
        }
    }
}

TEST(Sumd, RefusesOtherStatusesAndCounts) {
    for (unsigned status = 0; status <= 0xFF; ++status) {
        SumdDecoder decoder;
        const bool known = status == 0x01 || status == 0x03 || status == 0x81;
        EXPECT_EQ(feed(decoder, frame_of(static_cast<std::uint8_t>(status), {12000})).size(),
                  known ? 1U : 0U)
            << status;
    }
    SumdDecoder decoder;
    EXPECT_TRUE(feed(decoder, frame_of(0x01, {})).empty());
    EXPECT_TRUE(feed(decoder, frame_of(0x01, std::vector<std::uint16_t>(33, 12000))).empty());
}

TEST(Sumd, RefusesEachFlippedBitAndReadsTheNextFrame) {
    expect_each_flipped_bit_is_refused(make<SumdDecoder>, from_hex(kRecorded), from_hex(kRecorded));
}

TEST(Sumd, FindsAFrameBehindEveryCutOne) {
    expect_a_frame_behind_every_cut_one(make<SumdDecoder>, from_hex(kRecorded),
                                        from_hex(kEightChannels));
}

TEST(Sumd, APauseEndsAFrame) {
    expect_a_pause_ends_a_frame(make<SumdDecoder>, from_hex(kRecorded), from_hex(kFailsafe));
}

TEST(Sumd, WritesWhatItRead) {
    for (const auto& [hex, channels] :
         {std::pair(kEightChannels, 8U), std::pair(kRecorded, 12U), std::pair(kFailsafe, 8U)}) {
        EXPECT_EQ(encoded(decoded(hex), channels), from_hex(hex));
    }
}

TEST(Sumd, WritesAnAbsentChannelAsZeroAndNoPulseAsZero) {
    ChannelFrame frame;
    frame.failsafe = false;
    frame.set(0, Pulse::from_eighths(-20000));
    EXPECT_EQ(encoded(frame, 2), frame_of(0x01, {1, 0}));
}

TEST(Sumd, IsInTheRegistryAndHeardByDoctor) {
    EXPECT_EQ(find_protocol("sumd"), &kSumdProtocol);
    const doctor::LineStory story = story_of(kSumdProtocol, {from_hex(kRecorded)}, 10ms);
    EXPECT_EQ(story.protocol, "sumd");
    EXPECT_EQ(story.channels, 12U);
    EXPECT_EQ(story.period, std::optional<Duration>(10ms));
}

}  // namespace
}  // namespace tribus::test::sumd_test
