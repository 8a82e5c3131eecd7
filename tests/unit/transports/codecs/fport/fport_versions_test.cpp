#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/heard_line.h"
#include "tests/unit/transports/codecs/fport/fport_frames.h"
#include "transports/registry/registry.h"

namespace tribus::test::fport_versions_test {
namespace {

using namespace std::chrono_literals;
using namespace fport_frames;

TEST(FportDecoder, ReadsARecordedFrame) {
    FportDecoder decoder;
    const auto frames = feed(decoder, from_hex(kRecordedFport));
    ASSERT_EQ(frames.size(), 1U);
    expect_raw(frames[0].channels,
               {999, 999, 363, 999, 256, 746, 1810, 172, 992, 992, 992, 992, 992, 992, 992, 992});
    EXPECT_EQ(frames[0].length, 29U);
    EXPECT_EQ(decoder.details()[1].values[0], 56);
}

/// A frame in which `byte` stands at `at` of the packed channels.
Bytes with_packed(std::size_t at, std::uint8_t byte) {
    Bytes packed(22, 0x11);
    packed[at] = byte;
    return plain_fport1(plain_fport_unpacked(packed), 0, 60);
}

TEST(FportDecoder, ReadsAnEscapeInEachPlaceOfTheChannels) {
    for (std::size_t at = 0; at < 22; ++at) {
        for (const std::uint8_t byte : Bytes{0x7D, 0x7E}) {
            const Bytes bytes = with_packed(at, byte);
            ASSERT_GE(bytes.size(), 30U);
            for (const Split split : {kOneRead, kByteByByte}) {
                FportDecoder decoder;
                const auto frames = feed(decoder, bytes, split);
                ASSERT_EQ(frames.size(), 1U) << at;
                Bytes packed(22, 0x11);
                packed[at] = byte;
                expect_raw(frames[0].channels, plain_fport_unpacked(packed));
                EXPECT_EQ(frames[0].length, bytes.size());
            }
        }
    }
}

TEST(FportDecoder, ReadsAFrameInWhichEveryByteThatCanIsEscaped) {
    for (const std::uint8_t byte : Bytes{0x7D, 0x7E}) {
        const Raw raw = plain_fport_unpacked(Bytes(22, byte));
        const Bytes bytes = plain_fport1(raw, byte, byte);
        ASSERT_GE(bytes.size(), 53U);
        FportDecoder decoder;
        const auto frames = feed(decoder, bytes, kByteByByte);
        ASSERT_EQ(frames.size(), 1U);
        expect_raw(frames[0].channels, raw);
    }
}

TEST(FportDecoder, AMarkerInsideAFrameEndsIt) {
    const Bytes whole = plain_fport1(some(700), 0, 60);
    for (std::size_t at = 1; at + 1 < whole.size(); ++at) {
        Bytes bytes = whole;
        bytes[at] = 0x7E;
        append(bytes, whole);
        FportDecoder decoder;
        const auto frames = feed(decoder, bytes);
        ASSERT_EQ(frames.size(), 1U) << at;
        EXPECT_EQ(frames[0].first_byte, whole.size());
    }
}

TEST(FportDecoder, TakesNoFrameWithoutItsLastMarker) {
    Bytes bytes = from_hex(kRecordedFport);
    for (unsigned last = 0; last <= 0xFF; ++last) {
        bytes.back() = static_cast<std::uint8_t>(last);
        FportDecoder decoder;
        EXPECT_EQ(all_frames(decoder, bytes).size(), last == 0x7E ? 1U : 0U) << last;
    }
}

TEST(FportDecoder, TheFirstMarkerOfTheNextFrameMayEndAFrame) {
    Bytes bytes = plain_fport1(some(700), 0, 60);
    bytes.pop_back();
    for (const std::uint16_t first : Raw{900, 901}) {
        append(bytes, plain_fport1(some(first), 0, 60));
    }
    FportDecoder decoder;
    const auto frames = feed(decoder, bytes);
    ASSERT_EQ(frames.size(), 2U);
    expect_raw(frames[0].channels, some(700));
    expect_raw(frames[1].channels, some(901));
}

TEST(FportDecoder, TakesNoOtherLengthAndType) {
    for (unsigned length = 0; length <= 60; ++length) {
        for (unsigned type = 0; type <= 0xFF; ++type) {
            Bytes body{static_cast<std::uint8_t>(length), static_cast<std::uint8_t>(type)};
            body.resize(std::max<std::size_t>(length + 1, 2), 0x11);
            const Bytes bytes = plain_fport_marked(plain_fport_summed(body, 0));
            FportDecoder decoder;
            const bool channels = length == 0x19 && type == 0;
            ASSERT_EQ(all_frames(decoder, bytes).size(), channels ? 1U : 0U)
                << length << " " << type;
            const bool telemetry = length == 8 && (type == 0x01 || type == 0x81);
            ASSERT_EQ(decoder.skipped_bytes(), channels || telemetry ? 0U : bytes.size())
                << length << " " << type;
        }
    }
}

TEST(Fport2Decoder, ReadsRecordedFrames) {
    Fport2Decoder decoder;
    Bytes bytes = from_hex(kRecorded16);
    append(bytes, from_hex(kRecorded24));
    const auto frames = feed(decoder, bytes);
    ASSERT_EQ(frames.size(), 2U);
    expect_raw(frames[0].channels,
               {172, 992, 993, 992, 992, 992, 992, 992, 992, 992, 992, 992, 992, 992, 992, 992});
    expect_raw(frames[1].channels, {992, 992, 179, 993, 172, 992, 172, 172, 992, 1811, 172, 992,
                                    992, 992, 992, 992, 992, 992});
    EXPECT_EQ(decoder.details()[0].values.size(), 24U);
    EXPECT_EQ(decoder.details()[1].values[0], 91);
}

TEST(Fport2Decoder, ReadsEveryRawValueOfEightAndOfTwentyFourChannels) {
    for (const std::size_t count : {8U, 24U}) {
        for (std::uint16_t raw = 0; raw <= 2047; ++raw) {
            Fport2Decoder decoder;
            const auto frames = feed(decoder, plain_fport2(some(raw, count), 0, 60));
            ASSERT_EQ(frames.size(), 1U);
            ASSERT_EQ(frames[0].length, count == 8 ? 16U : 38U);
            expect_raw(frames[0].channels, some(raw, count));
            const auto values = decoder.details()[0].values;
            ASSERT_EQ(Raw(values.begin(), values.end()), some(raw, count));
        }
    }
}

TEST(Fport2Decoder, AShorterFrameKeepsNoChannelOfALongerOne) {
    Fport2Decoder decoder;
    Bytes bytes = plain_fport2(some(700, 24), 0, 60);
    append(bytes, plain_fport2(some(700, 16), 0, 60));
    append(bytes, plain_fport2(some(700, 8), 0, 60));
    const auto frames = feed(decoder, bytes);
    ASSERT_EQ(frames.size(), 3U);
    expect_raw(frames[0].channels, some(700, 24));
    expect_raw(frames[1].channels, some(700, 16));
    expect_raw(frames[2].channels, some(700, 8));
}

TEST(Fport2Decoder, TakesNoOtherLengthAndType) {
    for (unsigned length = 0; length <= 60; ++length) {
        for (unsigned type = 0; type <= 0xFF; ++type) {
            Bytes bytes{static_cast<std::uint8_t>(length), static_cast<std::uint8_t>(type)};
            bytes.resize(length == 8 ? 9 : length + 2, 0x11);
            bytes = plain_fport_summed(bytes, 1);
            Fport2Decoder decoder;
            const bool channels = (length == 13 || length == 24 || length == 35) && type == 0xFF;
            ASSERT_EQ(all_frames(decoder, bytes).size(), channels ? 1U : 0U)
                << length << " " << type;
            const bool known = channels || length == 8 || (length == 32 && type == 0xF1) ||
                               (length == 24 && (type == 0xF0 || type == 0xF2));
            ASSERT_EQ(decoder.skipped_bytes(), known ? 0U : bytes.size()) << length << " " << type;
        }
    }
}

TEST(Fport2Decoder, FindsAFrameInsideABadOneAndNoneInsideAGoodOne) {
    Bytes outer{0x20, 0xF1, 0x00};
    append(outer, plain_fport2(some(700), 0, 60));
    outer.resize(34, 0x11);
    Bytes bad = outer;
    bad.push_back(0x00);
    const Bytes good = plain_fport_summed(outer, 1);
    ASSERT_NE(good.back(), 0x00);
    Fport2Decoder in_good;
    EXPECT_TRUE(all_frames(in_good, good).empty());
    Fport2Decoder in_bad;
    const auto frames = all_frames(in_bad, bad);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].first_byte, 3U);
    EXPECT_EQ(count_of(in_bad, "checksum"), 1U);
}

TEST(FportScale, IsThatOfTheSetting) {
    for (const std::string_view name : {"betaflight", "ardupilot", "px4", "frsky", "futaba"}) {
        const SbusScale scale = *SbusScale::named(name);
        for (const std::size_t count : {8U, 16U, 24U}) {
            Fport2Decoder decoder(scale);
            const auto frames = feed(decoder, plain_fport2(some(3, count), 0, 60));
            ASSERT_EQ(frames.size(), 1U);
            for (std::size_t channel = 0; channel < std::min(count, kChannelCount); ++channel) {
                EXPECT_EQ(frames[0].channels.channel(channel),
                          scale.decode(some(3, count)[channel]))
                    << name;
            }
        }
        FportDecoder decoder(scale);
        const auto frames = feed(decoder, plain_fport1(some(3), 0, 60));
        ASSERT_EQ(frames.size(), 1U);
        EXPECT_EQ(frames[0].channels.channel(7), scale.decode(some(3)[7])) << name;
    }
}

TEST(FportProtocols, AreInTheRegistryAndHeardByDoctor) {
    EXPECT_EQ(find_protocol("fport"), &kFportProtocol);
    EXPECT_EQ(find_protocol("fport2"), &kFport2Protocol);
    EXPECT_EQ(find_protocol("fbus"), &kFbusProtocol);
    for (const Protocol* protocol : {&kFportProtocol, &kFport2Protocol, &kFbusProtocol}) {
        EXPECT_TRUE(protocol->line.inverted_wire);
        const doctor::LineStory story = story_of(
            *protocol, {from_hex(protocol == &kFportProtocol ? kRecordedFport : kRecorded24)}, 9ms);
        EXPECT_EQ(story.protocol, protocol->name);
        EXPECT_EQ(story.channels, protocol == &kFportProtocol ? 16U : 18U);
        EXPECT_EQ(story.period, std::optional<Duration>(9ms));
    }
}

}  // namespace
}  // namespace tribus::test::fport_versions_test
