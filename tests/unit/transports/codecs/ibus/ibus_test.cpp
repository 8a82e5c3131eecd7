#include "transports/codecs/ibus/ibus.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <numeric>
#include <optional>
#include <string_view>
#include <vector>

#include "tests/support/ibus_frames.h"
#include "tests/support/streams.h"

namespace tribus::ibus_test {
namespace {

using namespace test;

/// Appends the checksum of docs/protocols/ibus.md, "Servo frame".
Bytes sealed(Bytes body) {
    const unsigned sum = std::accumulate(body.begin(), body.end(), 0U);
    const unsigned checksum = 0xFFFFU - sum;
    body.push_back(static_cast<std::uint8_t>(checksum));
    body.push_back(static_cast<std::uint8_t>(checksum >> 8U));
    return body;
}

Bytes frame_of_words(std::span<const std::uint16_t> words) {
    Bytes body{static_cast<std::uint8_t>(4 + 2 * words.size()), 0x40};
    for (const std::uint16_t word : words) {
        body.push_back(static_cast<std::uint8_t>(word));
        body.push_back(static_cast<std::uint8_t>(word >> 8U));
    }
    return sealed(body);
}

std::optional<std::vector<int>> decode_hex(std::string_view hex) {
    const auto frame = decode_one(from_hex(hex));
    return frame ? std::optional(whole_microseconds(*frame)) : std::nullopt;
}

TEST(IbusDecoder, ReadsFourteenChannelsOfPublishedFrames) {
    EXPECT_EQ(decode_hex(kIa6bFrame),
              (std::vector{1499, 1500, 1364, 1500, 1000, 2000, 1490, 1000, 1500, 1500, 1500, 1500,
                           1500, 1500, -1, -1, -1, -1}));
    EXPECT_EQ(decode_hex(kIa6bFrame2015),
              (std::vector{1500, 1499, 1007, 1501, 2000, 2000, 1500, 1500, 1500, 1500, 1500, 1500,
                           1500, 1500, -1, -1, -1, -1}));
    EXPECT_EQ(decode_hex(kArduPilotFrame),
              (std::vector{1500, 1500, 1000, 1500, 1500, 1500, 1500, 1500, 1500, 1500, 1500, 1500,
                           1500, 1500, -1, -1, -1, -1}));
}

TEST(IbusDecoder, ReadsEighteenChannelsOfARealReceiver) {
    EXPECT_EQ(decode_hex(kFtr8bFrame),
              (std::vector{1493, 1515, 1349, 1448, 1500, 1500, 1500, 1500, 1500, 1500, 1500, 1500,
                           1500, 1500, 1500, 1500, 1500, 1500}));
}

TEST(IbusDecoder, ReadsBetaflightsTestFrameWithCommandZero) {
    EXPECT_EQ(decode_hex(kBetaflight18),
              (std::vector{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17}));
}

TEST(IbusDecoder, ReadsTheVariantWithHeader55) {
    EXPECT_EQ(decode_hex(kBetaflightIa6),
              (std::vector{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, -1, -1, -1, -1}));
}

TEST(IbusDecoder, SaysNeitherFailsafeNorFrameLost) {
    const auto frame = decode_one(from_hex(kIa6bFrame));
    ASSERT_TRUE(frame);
    EXPECT_TRUE(frame->good());
}

TEST(IbusDecoder, StampsAFrameWithTheInstantOfItsLastBytes) {
    IbusDecoder decoder;
    const Bytes bytes = from_hex(kIa6bFrame);
    const auto all = std::span<const std::uint8_t>(bytes);
    EXPECT_TRUE(feed(decoder, all.first(31), {}, Instant(std::chrono::milliseconds(1))).empty());
    const auto frames = feed(decoder, all.last(1), {}, Instant(std::chrono::milliseconds(2)));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].channels.received, Instant(std::chrono::milliseconds(2)));
}

TEST(IbusDecoder, TellsFourteenFromEighteenChannelsFrameByFrame) {
    Bytes bytes;
    for (const std::string_view frame : {kIa6bFrame, kFtr8bFrame, kIa6bFrame, kFtr8bFrame}) {
        append(bytes, from_hex(frame));
    }
    IbusDecoder decoder;
    const auto frames = feed(decoder, bytes);
    ASSERT_EQ(frames.size(), 4U);
    for (std::size_t index = 0; index < frames.size(); ++index) {
        for (std::size_t channel = 14; channel < kChannelCount; ++channel) {
            EXPECT_EQ(frames[index].channels.has(channel), index % 2 == 1);
        }
    }
}

// docs/protocols/ibus.md, "Channels 15 to 18": each nibble belongs to one place of one channel.
TEST(IbusDecoder, PutsEveryNibbleInItsChannel) {
    for (std::size_t slot = 0; slot < 14; ++slot) {
        for (unsigned nibble = 1; nibble < 16; ++nibble) {
            std::array<std::uint16_t, 14> words;
            words.fill(1500);
            words[slot] = static_cast<std::uint16_t>(1500 | nibble << 12U);
            const auto frame = decode_one(frame_of_words(words));
            ASSERT_TRUE(frame);
            std::vector<int> expected(14, 1500);
            expected.resize(18, -1);
            if (slot < 12) {
                expected[14 + slot / 3] = static_cast<int>(nibble << (4 * (slot % 3)));
            }
            ASSERT_EQ(whole_microseconds(*frame), expected)
                << "slot " << slot << " nibble " << nibble;
        }
    }
}

TEST(IbusDecoder, ReadsEveryValueOfEverySlot) {
    for (unsigned value = 0; value < 4096; ++value) {
        std::array<std::uint16_t, 14> words;
        std::vector<int> expected;
        for (unsigned slot = 0; slot < 14; ++slot) {
            words[slot] = static_cast<std::uint16_t>((value + 293 * slot) % 4096);
            expected.push_back(words[slot]);
        }
        expected.resize(18, -1);
        const auto frame = decode_one(frame_of_words(words));
        ASSERT_TRUE(frame);
        ASSERT_EQ(whole_microseconds(*frame), expected);
    }
}

TEST(IbusDecoder, ReadsShorterFramesOfEvenLength) {
    for (std::size_t count = 1; count <= 14; ++count) {
        const std::vector<std::uint16_t> words(count, 1234);
        const auto frame = decode_one(frame_of_words(words));
        ASSERT_TRUE(frame) << count << " channels";
        std::vector<int> expected(count, 1234);
        expected.resize(18, -1);
        EXPECT_EQ(whole_microseconds(*frame), expected);
    }
}

TEST(IbusDecoder, DoesNotReadChannels15To18FromAShorterFrame) {
    const std::vector<std::uint16_t> words(13, 0x55DC);
    const auto frame = decode_one(frame_of_words(words));
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->channel(0), kCentrePulse);
    EXPECT_FALSE(frame->has(14));
}

TEST(IbusDecoder, RefusesEveryOtherLengthAndCommand) {
    for (unsigned length = 0; length < 256; ++length) {
        for (unsigned command = 0; command < 256; ++command) {
            const bool servo = length >= 6 && length <= 32 && length % 2 == 0 && command == 0x40;
            const bool betaflight_test = length == 32 && command == 0;
            const bool worth_a_try = length <= 40 || command == 0x40 || command == 0;
            if (servo || betaflight_test || length < 4 || !worth_a_try) {
                continue;
            }
            Bytes body(length - 2, 0xFF);
            body[0] = static_cast<std::uint8_t>(length);
            body[1] = static_cast<std::uint8_t>(command);
            ASSERT_FALSE(decode_one(sealed(body))) << length << " " << command;
        }
    }
}

TEST(IbusDecoder, RefusesEveryWrongChecksum) {
    const Bytes good = from_hex(kIa6bFrame);
    for (unsigned checksum = 0; checksum < 0x10000; ++checksum) {
        Bytes bytes = good;
        bytes[30] = static_cast<std::uint8_t>(checksum);
        bytes[31] = static_cast<std::uint8_t>(checksum >> 8U);
        ASSERT_EQ(decode_one(bytes).has_value(), checksum == 0xF3DA);
    }
}

TEST(IbusDecoder, CountsAFrameWithAWrongChecksumOnce) {
    Bytes bytes = from_hex(kIa6bFrame);
    bytes[2] ^= 0x01U;
    append(bytes, from_hex(kIa6bFrame));
    IbusDecoder decoder;
    EXPECT_EQ(feed(decoder, bytes).size(), 1U);
    EXPECT_EQ(count_of(decoder, "checksum"), 1U);
    EXPECT_EQ(decoder.skipped_bytes(), 32U);
}

TEST(IbusDecoder, RefusesTheVariantWithHeader55WithAWrongSumOrWordsThatAreNoChannel) {
    Bytes bytes = from_hex(kBetaflightIa6);
    bytes[29] ^= 0x01U;
    EXPECT_FALSE(decode_one(bytes));
    bytes = from_hex(kBetaflightIa6);
    bytes[2] = 0x10;  // 0x1000 in the first word and in the sum
    bytes[30] = 0x10;
    EXPECT_FALSE(decode_one(bytes));
}

TEST(IbusDecoder, ReadsPlainSlotsAsSixteenBits) {
    std::array<std::uint16_t, 14> words;
    words.fill(1500);
    words[0] = 2000;
    words[1] = 0x1000;  // 4096 us: one more than a pulse holds
    const auto frame = decode_one(frame_of_words(words), IbusSlots::plain);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->channel(0), Pulse::from_microseconds(2000));
    EXPECT_EQ(frame->channel(1), Pulse::from_microseconds(4096));
    EXPECT_EQ(frame->channel(13), kCentrePulse);
    for (std::size_t channel = 14; channel < kChannelCount; ++channel) {
        EXPECT_FALSE(frame->has(channel));
    }
}

TEST(IbusDecoder, CountsIbus2FramesAndDecodesNoneOfThem) {
    Bytes bytes;
    for (int cycle = 0; cycle < 10; ++cycle) {
        append(bytes, from_hex(kIbus2Channels));
        append(bytes, from_hex(kIbus2Command));
        append(bytes, from_hex(kIbus2Response));
        append(bytes, from_hex(kIbus2MoreChannels));
    }
    IbusDecoder decoder;
    EXPECT_TRUE(feed(decoder, bytes).empty());
    EXPECT_EQ(count_of(decoder, "ibus2"), 20U);
    EXPECT_EQ(count_of(decoder, "checksum"), 0U);
    EXPECT_EQ(decoder.skipped_bytes(), bytes.size());
}

/// Calculates the CRC bit by bit from the polynomial; start value 0xFF.
std::uint8_t ibus2_crc(std::span<const std::uint8_t> bytes) {
    unsigned crc = 0xFF;
    for (const std::uint8_t byte : bytes) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc & 0x80U) != 0 ? (crc << 1U) ^ 0x125U : crc << 1U;
        }
    }
    return static_cast<std::uint8_t>(crc);
}

TEST(IbusDecoder, DoesNotReadAnIbusFrameThatStandsInsideAnIbus2Frame) {
    const Bytes inner = from_hex("06 40 dc 05 d8 fe");
    ASSERT_TRUE(decode_one(inner)) << "the frame inside must be good by itself";
    Bytes outer{0x00, 0x10, 0x07};
    append(outer, inner);
    outer.resize(15, 0xAA);
    outer.push_back(ibus2_crc(outer));
    IbusDecoder decoder;
    EXPECT_TRUE(feed(decoder, outer).empty());
    EXPECT_EQ(count_of(decoder, "ibus2"), 1U);
}

// docs/protocols/ibus.md, "Variants" and "Sensor bus: frames": servo and sensor wires tied together
// for one UART.
TEST(IbusDecoder, LosesNoFrameToTelemetryOnTheSameLine) {
    Bytes bytes;
    for (const std::string_view telemetry :
         {"04 f0 0b ff", "04 81 7a ff", "04 81 7a ff 04 81 7a ff", "04 91 6a ff 06 91 03 02 63 ff",
          "04 a1 5a ff", "04 a1 5a ff 06 a1 00 00 58 ff", "04 a2 59 ff 06 a2 fe ff 5a fd"}) {
        append(bytes, from_hex(telemetry));
        append(bytes, from_hex(kIa6bFrame));
        append(bytes, from_hex(telemetry));
        append(bytes, from_hex(kFtr8bFrame));
    }
    for (const test::Split split : {test::kOneRead, test::kByteByByte}) {
        IbusDecoder decoder;
        EXPECT_EQ(feed(decoder, bytes, split).size(), 14U);
        EXPECT_EQ(count_of(decoder, "checksum"), 0U);
        EXPECT_EQ(count_of(decoder, "ibus2"), 0U);
    }
}

TEST(IbusDecoder, NeverTakesATelemetryRequestForAFrame) {
    for (unsigned second = 0x80; second < 0x100; ++second) {
        const Bytes request = sealed({0x04, static_cast<std::uint8_t>(second)});
        ASSERT_FALSE(decode_one(request));
    }
}

TEST(IbusDecoder, CountsADamagedByteAndLosesItsFrameOnly) {
    const Bytes frame = from_hex(kIa6bFrame);
    Bytes bytes = frame;
    append(bytes, frame);
    IbusDecoder decoder;
    const auto frames =
        feed(decoder, bytes, {.kind = test::FaultKind::damaged, .position = 10}, test::kOneRead);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].first_byte, 32U);
    EXPECT_EQ(count_of(decoder, "damaged"), 1U);
    EXPECT_EQ(count_of(decoder, "checksum"), 0U);
    EXPECT_EQ(decoder.skipped_bytes(), 32U);
}

TEST(IbusDecoder, HasNothingToFinish) {
    IbusDecoder decoder;
    const Bytes frame = from_hex(kIa6bFrame);
    feed(decoder, std::span(frame).first(31));
    EXPECT_FALSE(decoder.finish());
}

}  // namespace
}  // namespace tribus::ibus_test
