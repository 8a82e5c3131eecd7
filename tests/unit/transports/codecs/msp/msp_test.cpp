#include "transports/codecs/msp/msp.h"

#include <array>
#include <chrono>
#include <cstdint>
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

namespace tribus::test::msp_test {
namespace {

using namespace std::chrono_literals;

// From the layout in Betaflight's msp_protocol.h and serial code.
constexpr std::string_view kEightChannels = "244d3c10c8dc05dc05e803dc05e803e803d007dc05e4";
const std::vector<double> kEightPulses{1500, 1500, 1000, 1500, 1000, 1000, 2000, 1500};
// MSP_SET_MOTOR as somebody's program logged it (christianrauch/msp, issue 62).
constexpr std::string_view kSetMotor = "244d3c10d6dc05dc054c04dc05000000000000000057";

/// A message towards a flight controller, with a right check.
Bytes message(std::uint8_t command, const Bytes& content) {
    Bytes bytes{'$', 'M', '<', static_cast<std::uint8_t>(content.size()), command};
    bytes.insert(bytes.end(), content.begin(), content.end());
    unsigned check = 0;
    for (std::size_t at = 3; at < bytes.size(); ++at) {
        check ^= bytes[at];
    }
    bytes.push_back(static_cast<std::uint8_t>(check));
    return bytes;
}

/// The same of version 2: the CRC-8 of DVB-S2 bit by bit.
Bytes message_2(std::uint16_t command, const Bytes& content) {
    Bytes bytes{'$', 'X', '<', 0};
    for (const std::size_t word : {std::size_t{command}, content.size()}) {
        bytes.push_back(static_cast<std::uint8_t>(word));
        bytes.push_back(static_cast<std::uint8_t>(word >> 8U));
    }
    bytes.insert(bytes.end(), content.begin(), content.end());
    bytes.push_back(reference::plain_crsf_check(std::span(bytes).subspan(3)));
    return bytes;
}

Bytes words(std::size_t count, unsigned word) {
    Bytes content;
    for (std::size_t i = 0; i < count; ++i) {
        content.push_back(static_cast<std::uint8_t>(word));
        content.push_back(static_cast<std::uint8_t>(word >> 8U));
    }
    return content;
}

Bytes encoded(const ChannelFrame& frame, std::size_t channels) {
    MspEncoder encoder(channels);
    return test::encoded(encoder, frame);
}

TEST(Msp, ReadsAndWritesTheVector) {
    MspDecoder decoder;
    const auto frames = feed(decoder, from_hex(kEightChannels));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(pulses_of(frames[0].channels), kEightPulses);
    EXPECT_TRUE(frames[0].channels.good());
    EXPECT_EQ(encoded(frames[0].channels, 8), from_hex(kEightChannels));
}

/// The frame of INAV's page about MSP v2 (iNavFlight/inav wiki, "MSP V2"): command 100 without
/// content, as a request.
TEST(Msp, PassesOverARequestOfVersion2) {
    const Bytes request = from_hex("24583C00640000008F");
    EXPECT_EQ(message_2(100, {}), request);
    MspDecoder decoder;
    EXPECT_TRUE(feed(decoder, request).empty());
    EXPECT_EQ(decoder.skipped_bytes(), 0U);
    EXPECT_EQ(decoder.rejected()[0].count, 0U);
}

/// mLRS sends its 16 channels so.
TEST(Msp, ReadsChannelsOfVersion2BesideThoseOfVersion1) {
    Bytes line = message_2(200, words(16, 1500));
    append(line, from_hex(kEightChannels));
    append(line, message_2(0x20C8, words(16, 1500)));
    append(line, message_2(200, words(16, 1900)));
    MspDecoder decoder;
    const auto frames = feed(decoder, line);
    ASSERT_EQ(frames.size(), 3U);
    EXPECT_EQ(pulses_of(frames[0].channels), std::vector<double>(16, 1500));
    EXPECT_EQ(pulses_of(frames[1].channels), kEightPulses);
    EXPECT_EQ(pulses_of(frames[2].channels), std::vector<double>(16, 1900));
    EXPECT_EQ(decoder.skipped_bytes(), 0U);
}

TEST(Msp, RefusesEachFlippedBitOfVersion2AndReadsTheNextFrame) {
    const Bytes frame = message_2(200, words(16, 1500));
    expect_each_flipped_bit_is_refused(make<MspDecoder>, frame, frame);
    expect_a_frame_behind_every_cut_one(make<MspDecoder>, frame, frame);
    expect_a_pause_ends_a_frame(make<MspDecoder>, frame, frame);
}

TEST(Msp, ReadsAndWritesEveryWordOfAPulseAndOthersAreNoChannel) {
    for (unsigned word = 0; word <= 0xFFFF; ++word) {
        const bool pulse = word >= 1 && word <= 4095;
        MspDecoder decoder;
        const Bytes bytes = message(200, words(1, word));
        const auto frames = feed(decoder, bytes);
        ASSERT_EQ(frames.size(), 1U) << word;
        const ChannelFrame& frame = frames[0].channels;
        ASSERT_EQ(frame.has(0), pulse) << word;
        if (pulse) {
            ASSERT_EQ(frame.channel(0)->microseconds(), word);
            ASSERT_EQ(encoded(frame, 1), bytes);
        }
    }
}

TEST(Msp, ReadsEveryNumberOfChannelsAndKeepsTheFirstEighteen) {
    for (std::size_t count = 1; count <= 32; ++count) {
        MspDecoder decoder;
        const auto frames = feed(decoder, message(200, words(count, 1500)));
        ASSERT_EQ(frames.size(), 1U) << count;
        EXPECT_EQ(pulses_of(frames[0].channels),
                  std::vector<double>(std::min<std::size_t>(count, 18), 1500));
    }
}

TEST(Msp, PassesOverOtherCommandsAndHalfWordsWithoutARejectedFrame) {
    MspDecoder decoder;
    Bytes line = from_hex(kSetMotor);
    for (const Bytes& other : {message(101, {}), message(200, {}), message(200, {0xDC, 0x05, 0x01}),
                               from_hex(kEightChannels)}) {
        line.insert(line.end(), other.begin(), other.end());
    }
    EXPECT_EQ(feed(decoder, line).size(), 1U);
    EXPECT_EQ(decoder.rejected()[0].count, 0U);
}

TEST(Msp, RefusesEachFlippedBitAndReadsTheNextFrame) {
    expect_each_flipped_bit_is_refused(make<MspDecoder>, from_hex(kEightChannels),
                                       from_hex(kEightChannels));
}

TEST(Msp, FindsAFrameBehindEveryCutOne) {
    expect_a_frame_behind_every_cut_one(make<MspDecoder>, from_hex(kEightChannels),
                                        from_hex(kEightChannels));
}

TEST(Msp, APauseEndsAFrame) {
    expect_a_pause_ends_a_frame(make<MspDecoder>, from_hex(kEightChannels),
                                from_hex(kEightChannels));
}

TEST(Msp, FindsAFrameBehindGarbageThatBeginsAsAMessageOfAnyLength) {
    for (unsigned length = 0; length <= 0xFF; ++length) {
        MspDecoder decoder;
        Bytes line{'$', 'M', '<', static_cast<std::uint8_t>(length)};
        for (int i = 0; i < 4; ++i) {
            const Bytes frame = from_hex(kEightChannels);
            line.insert(line.end(), frame.begin(), frame.end());
        }
        EXPECT_GE(feed(decoder, line).size(), 1U) << length;
    }
}

TEST(Msp, FindsAFrameBehindGarbageThatBeginsAsAMessageOfVersion2OfAnyLength) {
    for (unsigned length = 0; length <= 0xFFFF; length += length < 0x100 ? 1 : 0xFF) {
        MspDecoder decoder;
        Bytes line{'$',
                   'X',
                   '<',
                   0,
                   200,
                   0,
                   static_cast<std::uint8_t>(length),
                   static_cast<std::uint8_t>(length >> 8U)};
        for (int i = 0; i < 4; ++i) {
            append(line, from_hex(kEightChannels));
        }
        EXPECT_GE(feed(decoder, line).size(), 1U) << length;
    }
}

TEST(Msp, WritesWholeMicrosecondsOfEveryChannelAndNeedsThemAll) {
    ChannelFrame frame;
    frame.set(0, Pulse::from_eighths(8 * 1500 + 3));
    frame.set(1, Pulse::from_eighths(8 * 1500 + 4));
    frame.set(2, Pulse::from_eighths(-20000));
    EXPECT_EQ(encoded(frame, 4), message(200, {0xDC, 0x05, 0xDD, 0x05, 0x01, 0x00, 0xDC, 0x05}));
    EXPECT_EQ(MspEncoder(4).needed_channels(frame), 0b1111U);
}

TEST(Msp, IsInTheRegistryAndHeardByDoctor) {
    EXPECT_EQ(find_protocol("msp"), &kMspProtocol);
    const doctor::LineStory story = story_of(kMspProtocol, {from_hex(kEightChannels)}, 20ms);
    EXPECT_EQ(story.protocol, "msp");
    EXPECT_EQ(story.channels, 8U);
}

}  // namespace
}  // namespace tribus::test::msp_test
