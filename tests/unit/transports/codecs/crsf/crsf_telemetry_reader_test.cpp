#include "transports/codecs/crsf/telemetry_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tests/reference/plain_crsf.h"
#include "tests/support/streams.h"
#include "transports/codecs/crsf/telemetry.h"
#include "transports/codecs/crsf/telemetry_numbers.h"
#include "transports/registry/registry.h"

namespace tribus::test::crsf_telemetry_reader_test {
namespace {

using reference::plain_crsf;
using Numbers = std::map<std::string, double>;

constexpr Instant kNow = Instant(std::chrono::hours(1));
// Betaflight, telemetry_crsf_unittest.cc: 3.3 V, 29.6 A, 1234 mAh, 67 %.
constexpr std::string_view kBattery = "C80A08002101280004D243B2";
// The same test: 56 and 163 degrees, 58.7 km/h, 147.9 degrees, 2345 m, 9 satellites.
constexpr std::string_view kGps = "C811022160EC006127D380024B39C60D11096B";

/// The numbers of each message in the bytes, in the order of their arrival.
std::vector<Numbers> messages_in(CrsfTelemetryReader& reader, std::span<const std::uint8_t> bytes) {
    std::vector<Numbers> messages;
    std::vector<ValueReading> readings(reader.values().size());
    while (reader.next(bytes, kNow, readings)) {
        Numbers& numbers = messages.emplace_back();
        for (std::size_t i = 0; i < readings.size(); ++i) {
            if (readings[i].state == ValueReading::State::number) {
                numbers[reader.values()[i].name] = readings[i].number;
            }
        }
    }
    EXPECT_TRUE(bytes.empty());
    return messages;
}
std::vector<Numbers> messages_in(const Bytes& bytes) {
    CrsfTelemetryReader reader;
    return messages_in(reader, bytes);
}
Numbers numbers_in(const Bytes& bytes) {
    const auto messages = messages_in(bytes);
    EXPECT_EQ(messages.size(), 1U);
    return messages.empty() ? Numbers{} : messages.front();
}

TEST(CrsfTelemetryReader, ReadsABattery) {
    EXPECT_EQ(numbers_in(from_hex(kBattery)), (Numbers{{"battery.voltage", 3.3},
                                                       {"battery.current", 29.6},
                                                       {"battery.consumed", 1234},
                                                       {"battery.remaining", 67}}));
}

TEST(CrsfTelemetryReader, ReadsAPosition) {
    EXPECT_EQ(numbers_in(from_hex(kGps)), (Numbers{{"gps.latitude", 56},
                                                   {"gps.longitude", 163},
                                                   {"gps.speed", 58.7},
                                                   {"gps.heading", 147.9},
                                                   {"gps.altitude", 2345},
                                                   {"gps.satellites", 9}}));
}

TEST(CrsfTelemetryReader, ReadsSignedNumbers) {
    // Betaflight: pitch 1.1833 rad, roll 2.6092 rad, yaw -3.1398 rad.
    const Numbers attitude = numbers_in(from_hex("C8081E2E3965EC855A05"));
    EXPECT_NEAR(attitude.at("attitude.pitch"), 67.798, 0.001);
    EXPECT_NEAR(attitude.at("attitude.roll"), 149.496, 0.001);
    EXPECT_NEAR(attitude.at("attitude.yaw"), -179.897, 0.001);
    EXPECT_EQ(numbers_in(plain_crsf(0xC8, 0x07, {0xFF, 0x38})), (Numbers{{"vario", -2}}));
    EXPECT_EQ(numbers_in(plain_crsf(0xC8, 0x0C, {0, 0xFF, 0xFF, 0xFF})), (Numbers{{"rpm.1", -1}}));
}

TEST(CrsfTelemetryReader, ReadsSeveralNumbersOfAKind) {
    EXPECT_EQ(numbers_in(plain_crsf(0xC8, 0x0E, {0, 0x0E, 0x74, 0x10, 0x68})),
              (Numbers{{"cells.1", 3.7}, {"cells.2", 4.2}}));
    EXPECT_EQ(numbers_in(plain_crsf(0xC8, 0x0D, {0, 0x00, 0xFA})),
              (Numbers{{"temperature.1", 25}}));
}

TEST(CrsfTelemetryReader, ReadsTheLinkStatisticsOfAModule) {
    const Numbers link =
        numbers_in(plain_crsf(0xEA, 0x14, {70, 80, 99, 0xF6, 1, 7, 3, 60, 98, 0x05}));
    EXPECT_EQ(link, (Numbers{{"link.up_rssi_1", -70},
                             {"link.up_rssi_2", -80},
                             {"link.up_quality", 99},
                             {"link.up_snr", -10},
                             {"link.antenna", 1},
                             {"link.mode", 7},
                             {"link.power_number", 3},
                             {"link.down_rssi", -60},
                             {"link.down_quality", 98},
                             {"link.down_snr", 5}}));
}

/// TBS's text, "0x09 Barometric Altitude & Vertical Speed": 0 is -1000 m, 10000 is 0 m, 7FFF is
/// 2276.7 m; with the highest bit whole metres. 127 is about 26 m/s.
TEST(CrsfTelemetryReader, ReadsTheBarometer) {
    const auto altitude = [](std::uint8_t high, std::uint8_t low) {
        return numbers_in(plain_crsf(0xC8, 0x09, {high, low, 0})).at("baro.altitude");
    };
    EXPECT_EQ(altitude(0x00, 0x00), -1000);
    EXPECT_EQ(altitude(0x27, 0x10), 0);
    EXPECT_EQ(altitude(0x27, 0x0F), -0.1);
    EXPECT_EQ(altitude(0x7F, 0xFF), 2276.7);
    EXPECT_EQ(altitude(0x88, 0xE5), 2277);
    EXPECT_EQ(altitude(0xFF, 0xFE), 32766);
    const auto climb = [](std::uint8_t packed) {
        return numbers_in(plain_crsf(0xC8, 0x09, {0x27, 0x10, packed})).at("baro.vario");
    };
    EXPECT_EQ(climb(0), 0);
    EXPECT_NEAR(climb(1), 0.026, 0.001);
    EXPECT_NEAR(climb(0xFF), -0.026, 0.001);
    EXPECT_NEAR(climb(127), 26.16, 0.01);
    EXPECT_NEAR(climb(0x81), -26.16, 0.01);
}

/// As Betaflight and older flight controllers send it.
TEST(CrsfTelemetryReader, ReadsABarometerWithoutVerticalSpeed) {
    EXPECT_EQ(numbers_in(plain_crsf(0xC8, 0x09, {0x27, 0x74})), (Numbers{{"baro.altitude", 10}}));
    EXPECT_TRUE(messages_in(plain_crsf(0xC8, 0x09, {0x27})).empty());
}

TEST(CrsfTelemetryReader, ReadsTheStatisticsOfBothSides) {
    EXPECT_EQ(numbers_in(plain_crsf(0xEA, 0x1C, {70, 80, 99, 0xF6, 20})),
              (Numbers{{"receiver_link.rssi", -70},
                       {"receiver_link.rssi_percent", 80},
                       {"receiver_link.quality", 99},
                       {"receiver_link.snr", -10},
                       {"receiver_link.power", 20}}));
    EXPECT_EQ(numbers_in(plain_crsf(0xEA, 0x1D, {60, 90, 98, 5, 0xFD, 15})),
              (Numbers{{"transmitter_link.rssi", -60},
                       {"transmitter_link.rssi_percent", 90},
                       {"transmitter_link.quality", 98},
                       {"transmitter_link.snr", 5},
                       {"transmitter_link.power", -3},
                       {"transmitter_link.frame_rate", 150}}));
}

TEST(CrsfTelemetryReader, TakesALongerMessageAndNoShorterOne) {
    EXPECT_EQ(numbers_in(plain_crsf(0xC8, 0x07, {0, 100, 0x55})), (Numbers{{"vario", 1}}));
    for (const TelemetryMessage& message : kTelemetryMessages) {
        std::size_t bytes = message.form == TelemetryForm::numbered ? 1 : 0;
        for (const TelemetryNumber& number : message.numbers) {
            bytes += number.bytes;
        }
        EXPECT_EQ(messages_in(plain_crsf(0xC8, message.type, Bytes(bytes))).size(), 1U)
            << message.key;
        EXPECT_TRUE(messages_in(plain_crsf(0xC8, message.type, Bytes(bytes - 1))).empty())
            << message.key;
    }
}

TEST(CrsfTelemetryReader, PassesOverOtherSourcesAndOtherTypes) {
    EXPECT_TRUE(messages_in(plain_crsf(0xC8, 0x0E, {1, 0x0E, 0x74})).empty());
    EXPECT_TRUE(messages_in(plain_crsf(0xC8, 0x21, {'A', 'C', 'R', 'O', 0})).empty());
    EXPECT_TRUE(messages_in(plain_crsf(0xC8, 0x16, Bytes(22))).empty());
    // The time and the accuracy of a position: docs/protocols/crsf.md, "Telemetry".
    EXPECT_TRUE(messages_in(plain_crsf(0xC8, 0x03, Bytes(9))).empty());
    EXPECT_TRUE(messages_in(plain_crsf(0xC8, 0x06, Bytes(20))).empty());
}

TEST(CrsfTelemetryReader, ReadsEveryMessageWhereverTheReadsAreCut) {
    Bytes stream = from_hex(kBattery);
    append(stream, from_hex(kGps));
    append(stream, from_hex(kBattery));
    for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
        CrsfTelemetryReader reader;
        const auto before = messages_in(reader, std::span(stream).first(cut));
        const auto behind = messages_in(reader, std::span(stream).subspan(cut));
        EXPECT_EQ(before.size() + behind.size(), 3U) << cut;
    }
}

TEST(CrsfTelemetryReader, RefusesEachFlippedBit) {
    const Bytes good = from_hex(kBattery);
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
        Bytes bytes = good;
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
        const auto messages = messages_in(bytes);
        // The address is outside of the check; some of its bits make another address.
        EXPECT_TRUE(messages.empty() || (bit < 8 && messages.size() == 1)) << bit;
    }
}

TEST(CrsfTelemetryReader, ADamagedByteSpoilsItsMessageOnly) {
    CrsfTelemetryReader reader;
    const Bytes battery = from_hex(kBattery);
    EXPECT_TRUE(messages_in(reader, std::span(battery).first(5)).empty());
    reader.damaged_byte();
    EXPECT_TRUE(messages_in(reader, std::span(battery).subspan(6)).empty());
    EXPECT_EQ(messages_in(reader, battery).size(), 1U);
}

TEST(CrsfTelemetryReader, ForgetsWhatCameBeforeTheLineWasUnplugged) {
    CrsfTelemetryReader reader;
    const Bytes battery = from_hex(kBattery);
    EXPECT_TRUE(messages_in(reader, std::span(battery).first(5)).empty());
    reader.reset();
    EXPECT_TRUE(messages_in(reader, std::span(battery).subspan(5)).empty());
}

/// An encoder of that message with a value in the place of one of its numbers, and zero in others.
CrsfTelemetryEncoder encoder_of(const TelemetryMessage& message, std::size_t place) {
    CrsfTelemetryFrame frame{.type = message.type};
    frame.prefix.assign(message.form == TelemetryForm::numbered ? 1 : 0, 0);
    for (std::size_t i = 0; i < message.numbers.size(); ++i) {
        const TelemetryNumber& number = message.numbers[i];
        frame.fields.push_back({.value = i == place ? "it" : "",
                                .path = {},
                                .unit = number.unit,
                                .scale = number.scale,
                                .offset = number.offset,
                                .bytes = number.bytes,
                                .is_signed = number.is_signed});
    }
    return CrsfTelemetryEncoder({std::move(frame)});
}

/// Every value of a number of one or two bytes, and many of the longer ones, comes back.
TEST(CrsfTelemetryReader, ReadsWhatTheEncoderWritesOverTheWholeRange) {
    CrsfTelemetryReader reader;
    std::vector<ValueReading> readings(reader.values().size());
    std::size_t first = 0;
    for (const TelemetryMessage& message : kTelemetryMessages) {
        for (std::size_t place = 0; place < message.numbers.size(); ++place) {
            const TelemetryNumber& number = message.numbers[place];
            CrsfTelemetryEncoder encoder = encoder_of(message, place);
            ValueBoard board({{"it", "", kForever}});
            encoder.use(board);
            const double range = std::ldexp(1.0, static_cast<int>(8 * number.bytes));
            const double steps = std::min(range, 65536.0);
            for (double step = 0; step < steps; ++step) {
                const double raw =
                    std::floor(step / steps * range) - (number.is_signed ? range / 2 : 0);
                const double value = (raw - number.offset) / number.scale;
                board.set(0, value, kNow);
                std::array<std::uint8_t, kLongestSerialFrame> wire{};
                std::span<const std::uint8_t> bytes(wire);
                bytes = bytes.first(encoder.write({}, wire, kNow));
                ASSERT_TRUE(reader.next(bytes, kNow, readings));
                ASSERT_EQ(readings[first + place].state, ValueReading::State::number);
                ASSERT_DOUBLE_EQ(readings[first + place].number, value) << message.key;
            }
        }
        first += message.numbers.size() * message.most;
    }
}

TEST(CrsfTelemetryReader, IsListedAmongTheProtocolsWithValues) {
    std::vector<std::string_view> named;
    for (const Protocol* protocol : protocols()) {
        if (protocol->make_value_reader != nullptr) {
            named.push_back(protocol->name);
        }
    }
    EXPECT_TRUE(std::ranges::equal(named, kValueProtocols));
}

}  // namespace
}  // namespace tribus::test::crsf_telemetry_reader_test
