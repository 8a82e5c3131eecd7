#include "transports/codecs/fport/fport.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "app/doctor/line_judge.h"
#include "tests/reference/plain_fport.h"
#include "tests/support/streams.h"
#include "transports/registry/registry.h"

namespace tribus::test::fport_test {
namespace {

using namespace std::chrono_literals;
using namespace reference;
using Raw = std::vector<std::uint16_t>;

// ArduPilot, RCProtocolTest.cpp: fport_bytes, fport2_16ch_bytes, fport2_24ch_bytes.
constexpr std::string_view kRecordedFport =
    "7e1900e73bdf5ace071075499c15e0031ff8c0073ef0810f7c0038fa7e";
constexpr std::string_view kRecorded16 = "18ffac005ff8c0073ef0810f7ce0031ff8c0073ef0810f7c005e98";
constexpr std::string_view kRecorded24 =
    "23ffe003df2cc2c70af0b18215e09b382bc0073ef0810f7ce0031ff8c0073ef0810f7c005b02";
// Computed: 08, physical id 1B, primitive 10 (data), application id 0210, 4 bytes.
constexpr std::string_view kTelemetry2 = "081b10100212345678ad";
// Computed: a request and a reply of F.Port, the reply without markers and with an escaped 7E.
constexpr std::string_view kRequest = "7e080100000000000000f67e";
constexpr std::string_view kReply = "0881107d5e1000000000d7";

/// What a test needs of one of the two formats.
struct Format {
    std::string_view name;
    std::unique_ptr<ByteDecoder> (*decoder)();
    Bytes (*channels)(const Raw& raw, std::uint8_t flags, std::uint8_t rssi);
    std::vector<PlainFportFrame> (*plain)(const Bytes& stream);
    Bytes (*telemetry)();
};

const Format kVersion1{
    .name = "Fport",
    .decoder = [] { return std::unique_ptr<ByteDecoder>(std::make_unique<FportDecoder>()); },
    .channels = plain_fport1,
    .plain = [](const Bytes& bytes) { return plain_fport_frames(bytes, plain_fport1_frame); },
    .telemetry =
        [] {
            Bytes both = from_hex(kRequest);
            append(both, from_hex(kReply));
            return both;
        },
};
const Format kVersion2{
    .name = "Fport2",
    .decoder = [] { return std::unique_ptr<ByteDecoder>(std::make_unique<Fport2Decoder>()); },
    .channels = plain_fport2,
    .plain = [](const Bytes& bytes) { return plain_fport_frames(bytes, plain_fport2_frame); },
    .telemetry =
        [] {
            Bytes both = from_hex(kTelemetry2);
            append(both, from_hex(kTelemetry2));
            return both;
        },
};

/// Raw values that differ from each other, none with an escape.
Raw some(std::uint16_t first, std::size_t count = 16) {
    Raw raw(count);
    for (std::size_t i = 0; i < count; ++i) {
        raw[i] = static_cast<std::uint16_t>((first + 131 * i) % 2048);
    }
    return raw;
}

std::vector<DecodedFrame> all_of(ByteDecoder& decoder, const Bytes& bytes, Split split = kOneRead) {
    auto frames = feed(decoder, bytes, split);
    for (DecodedFrame late; decoder.silence(late);) {
        frames.push_back(late);
    }
    return frames;
}

void expect_raw(const ChannelFrame& frame, const Raw& raw) {
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (channel >= raw.size()) {
            ASSERT_FALSE(frame.has(channel)) << channel;
            ASSERT_EQ(frame.pulses()[channel], Pulse{});
            continue;
        }
        ASSERT_EQ(frame.channel(channel)->eighths(), (raw[channel] - 992) * 5 + 12000) << channel;
    }
}

class FportFormats : public testing::TestWithParam<Format> {
  protected:
    const Format& format() const { return GetParam(); }
    Bytes four_frames() const {
        Bytes bytes;
        for (std::uint16_t i = 0; i < 4; ++i) {
            append(bytes, format().channels(some(static_cast<std::uint16_t>(700 + 37 * i)), 0, 50));
            append(bytes, format().telemetry());
        }
        return bytes;
    }
    /// Compares with the plain form, all values.
    void expect_as_plain(const Bytes& bytes, Split split, std::uint32_t seed) const {
        const auto decoder = format().decoder();
        const auto frames = all_of(*decoder, bytes, split);
        auto plain = format().plain(bytes);
        std::erase_if(plain, [](const auto& frame) { return !frame.has_channels; });
        ASSERT_EQ(frames.size(), plain.size()) << seed;
        for (std::size_t i = 0; i < frames.size(); ++i) {
            ASSERT_EQ(frames[i].first_byte, plain[i].at) << seed;
            ASSERT_EQ(frames[i].length, plain[i].length) << seed;
            ASSERT_EQ(frames[i].channels.frame_lost, (plain[i].flags & 4) != 0) << seed;
            ASSERT_EQ(frames[i].channels.failsafe, (plain[i].flags & 8) != 0) << seed;
            expect_raw(frames[i].channels, plain[i].raw);
        }
    }
};

TEST_P(FportFormats, ReadEveryRawValueOfEveryChannelExactly) {
    for (std::uint16_t raw = 0; raw <= 2047; ++raw) {
        for (const Split split : {kOneRead, kByteByByte}) {
            const auto decoder = format().decoder();
            const auto frames = feed(*decoder, format().channels(some(raw), 0, 60), split);
            ASSERT_EQ(frames.size(), 1U) << raw;
            expect_raw(frames[0].channels, some(raw));
            ASSERT_TRUE(frames[0].channels.good());
        }
    }
}

TEST_P(FportFormats, ReadFrameLostAndFailsafeAndNoSwitches) {
    for (unsigned flags = 0; flags <= 0xFF; ++flags) {
        const auto decoder = format().decoder();
        const auto frames =
            feed(*decoder, format().channels(some(992), static_cast<std::uint8_t>(flags), 60));
        ASSERT_EQ(frames.size(), 1U) << flags;
        EXPECT_EQ(frames[0].channels.frame_lost, (flags & 4) != 0);
        EXPECT_EQ(frames[0].channels.failsafe, (flags & 8) != 0);
        EXPECT_FALSE(frames[0].channels.has(16));
        EXPECT_FALSE(frames[0].channels.has(17));
    }
}

TEST_P(FportFormats, AFrameAfterABadLinkHasItsOwnFlags) {
    const auto decoder = format().decoder();
    Bytes bytes = format().channels(some(992), 0x0C, 60);
    append(bytes, format().channels(some(992), 0x00, 60));
    const auto frames = feed(*decoder, bytes);
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_FALSE(frames[0].channels.good());
    EXPECT_TRUE(frames[1].channels.good());
}

TEST_P(FportFormats, RawValuesAndRssiAreDetails) {
    const auto decoder = format().decoder();
    EXPECT_TRUE(decoder->details().empty());
    feed(*decoder, format().channels(some(5), 0, 77));
    const auto details = decoder->details();
    ASSERT_EQ(details.size(), 2U);
    EXPECT_EQ(details[0].name, "raw");
    EXPECT_EQ(Raw(details[0].values.begin(), details[0].values.end()), some(5));
    EXPECT_EQ(details[1].name, "rssi");
    EXPECT_EQ(details[1].values[0], 77);
    EXPECT_EQ(decoder->radio_statistics(), nullptr);
}

TEST_P(FportFormats, PassOverTelemetryWithoutARejection) {
    for (const Split split : {kOneRead, kByteByByte}) {
        const auto decoder = format().decoder();
        const auto frames = all_of(*decoder, four_frames(), split);
        EXPECT_EQ(frames.size(), 4U);
        EXPECT_EQ(decoder->skipped_bytes(), 0U);
        EXPECT_EQ(count_of(*decoder, "checksum"), 0U);
    }
}

TEST_P(FportFormats, RefuseEachFlippedBit) {
    const Bytes good = format().channels(some(700), 0, 60);
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
        Bytes bytes = good;
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
        for (const Split split : {kOneRead, kByteByByte}) {
            const auto decoder = format().decoder();
            EXPECT_TRUE(all_of(*decoder, bytes, split).empty()) << bit;
        }
    }
}

TEST_P(FportFormats, LoseOneFrameAtMostByAByteThatIsLostOrAddedAnywhere) {
    const Bytes good = four_frames();
    for (std::size_t at = 0; at < good.size(); ++at) {
        std::vector<Fault> faults{{FaultKind::lost, at}, {FaultKind::damaged, at}};
        for (const std::uint8_t value : Bytes{0x00, 0x08, 0x18, 0x19, 0x7D, 0x7E, 0xFF}) {
            faults.push_back({FaultKind::added, at, value});
        }
        for (const Fault& fault : faults) {
            for (const Split split : {kOneRead, kByteByByte}) {
                const auto decoder = format().decoder();
                auto frames = feed(*decoder, good, fault, split);
                for (DecodedFrame late; decoder->silence(late);) {
                    frames.push_back(late);
                }
                EXPECT_GE(frames.size(), 3U) << fault;
                EXPECT_LE(frames.size(), 4U) << fault;
            }
        }
    }
}

TEST_P(FportFormats, FindAFrameBehindAnyFalseBeginning) {
    const Bytes whole = format().channels(some(700), 0, 60);
    for (std::size_t cut = 1; cut < whole.size(); ++cut) {
        if (whole[cut] == 0x7E) {
            continue;  // TheFirstMarkerOfTheNextFrameMayEndAFrame
        }
        Bytes bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut));
        append(bytes, format().channels(some(900), 0, 60));
        for (const Split split : {kOneRead, kByteByByte}) {
            const auto decoder = format().decoder();
            const auto frames = all_of(*decoder, bytes, split);
            ASSERT_EQ(frames.size(), 1U) << cut;
            EXPECT_EQ(frames[0].first_byte, cut);
        }
    }
}

TEST_P(FportFormats, APauseEndsAnIncompleteFrame) {
    const Bytes whole = format().channels(some(700), 0, 60);
    for (std::size_t cut = 1; cut < whole.size(); ++cut) {
        const auto decoder = format().decoder();
        EXPECT_TRUE(feed(*decoder, std::span(whole).first(cut)).empty());
        DecodedFrame late;
        EXPECT_FALSE(decoder->silence(late));
        EXPECT_TRUE(feed(*decoder, std::span(whole).subspan(cut)).empty()) << cut;
    }
}

TEST_P(FportFormats, FindTheSameHoweverTheStreamIsCutIntoReads) {
    const Bytes bytes = four_frames();
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
        const auto decoder = format().decoder();
        std::vector<DecodedFrame> frames;
        feed_into(frames, *decoder, std::span(bytes).first(cut));
        feed_into(frames, *decoder, std::span(bytes).subspan(cut));
        ASSERT_EQ(frames.size(), 4U) << cut;
    }
}

TEST_P(FportFormats, FindWhatThePlainFormFindsOnAnyLine) {
    constexpr std::array<std::uint8_t, 8> kLikely{0x08, 0x0D, 0x18, 0x19, 0x23, 0x7D, 0x7E, 0xFF};
    for (std::uint32_t seed = 1; seed <= 600; ++seed) {
        Random random(seed);
        Bytes bytes;
        while (bytes.size() < 400) {
            const std::uint32_t kind = random.below(6);
            if (kind == 0) {
                bytes.push_back(random.byte());
            } else if (kind == 1) {
                bytes.push_back(kLikely[random.below(kLikely.size())]);
            } else if (kind == 2) {
                append(bytes, format().telemetry());
            } else {
                Raw raw(16);
                for (std::uint16_t& value : raw) {
                    value = static_cast<std::uint16_t>(random.below(2048));
                }
                append(bytes, format().channels(raw, random.byte(), random.byte()));
            }
        }
        for (std::uint32_t fault = 0; fault < seed % 4; ++fault) {
            bytes[random.below(400)] =
                seed % 3 == 0 ? random.byte() : kLikely[random.below(kLikely.size())];
        }
        expect_as_plain(bytes, {.longest = 40, .seed = seed}, seed);
        expect_as_plain(bytes, kOneRead, seed);
    }
}

INSTANTIATE_TEST_SUITE_P(Fport, FportFormats, testing::Values(kVersion1, kVersion2),
                         [](const auto& format) { return std::string(format.param.name); });

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
        EXPECT_EQ(all_of(decoder, bytes).size(), last == 0x7E ? 1U : 0U) << last;
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
            ASSERT_EQ(all_of(decoder, bytes).size(), channels ? 1U : 0U) << length << " " << type;
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
            ASSERT_EQ(all_of(decoder, bytes).size(), channels ? 1U : 0U) << length << " " << type;
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
    EXPECT_TRUE(all_of(in_good, good).empty());
    Fport2Decoder in_bad;
    const auto frames = all_of(in_bad, bad);
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
        doctor::Heard heard{.line = protocol->line, .listened = 1s, .bursts = {}};
        for (int i = 0; i < 100; ++i) {
            const Bytes bytes =
                from_hex(protocol == &kFportProtocol ? kRecordedFport : kRecorded24);
            heard.bursts.push_back(
                {.start = i * 9ms, .bytes = bytes, .damaged = std::vector<bool>(bytes.size())});
        }
        const doctor::LineStory story = doctor::judge_line(std::span(&heard, 1));
        EXPECT_EQ(story.protocol, protocol->name);
        EXPECT_EQ(story.channels, protocol == &kFportProtocol ? 16U : 18U);
        EXPECT_EQ(story.period, std::optional<Duration>(9ms));
    }
}

}  // namespace
}  // namespace tribus::test::fport_test
