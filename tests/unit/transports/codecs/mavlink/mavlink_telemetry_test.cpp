#include "transports/codecs/mavlink/telemetry.h"

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/mavlink/mavlink_messages.h"
#include "transports/registry/registry.h"

namespace tribus::test::mavlink_telemetry_test {
namespace {

using namespace std::chrono_literals;

constexpr double kNotAvailable = -1e9;
using Numbers = std::map<std::string, double>;

/// The numbers of each message, by name; those that a message does not hold are left out.
std::vector<Numbers> read(MavlinkTelemetryReader& reader, const Bytes& bytes, Instant at = {}) {
    std::vector<ValueReading> readings(reader.values().size());
    std::vector<Numbers> messages;
    std::span<const std::uint8_t> rest(bytes);
    while (reader.next(rest, at, readings)) {
        Numbers& numbers = messages.emplace_back();
        for (std::size_t i = 0; i < readings.size(); ++i) {
            if (readings[i].state != ValueReading::State::absent) {
                numbers[reader.values()[i].name] = readings[i].state == ValueReading::State::number
                                                       ? readings[i].number
                                                       : kNotAvailable;
            }
        }
    }
    return messages;
}

Numbers numbers_of(const Bytes& message) {
    MavlinkTelemetryReader reader;
    const auto messages = read(reader, message);
    EXPECT_EQ(messages.size(), 1U);
    return messages.empty() ? Numbers{} : messages[0];
}

void expect_near(const Numbers& numbers, const Numbers& expected) {
    ASSERT_EQ(numbers.size(), expected.size());
    for (const auto& [name, value] : expected) {
        ASSERT_TRUE(numbers.contains(name)) << name;
        EXPECT_NEAR(numbers.at(name), value, 1e-5 * std::abs(value) + 1e-9) << name;
    }
}

// The payloads are written by hand from common.xml; the units are those of its fields.

TEST(MavlinkTelemetry, ReadsTheStateOfTheSystem) {
    // load 25.0 %, 12.6 V, 3.45 A, 87 %.
    const Bytes payload = from_hex(
        "00000000 00000000 00000000 fa00 3831 5901 0000 0000 0000 0000"
        "0000 0000 57");
    expect_near(numbers_of(message_2(1, 124, payload)), {{"system.load", 25},
                                                         {"system.voltage", 12.6},
                                                         {"system.current", 3.45},
                                                         {"system.remaining", 87}});
}

TEST(MavlinkTelemetry, ReadsPositionSpeedAndSatellites) {
    // 48.1371536 deg, -11.5753822 deg, 519.123 m, 12.34 m/s, 271.50 deg, fix 3, 14 satellites.
    const Bytes payload =
        from_hex("0000000000000000 9025b11c a2bc19f9 d3eb0700 ffff ffff d204 0e6a 03 0e");
    expect_near(numbers_of(message_2(24, 24, payload)), {{"gps.fix", 3},
                                                         {"gps.latitude", 48.1371536},
                                                         {"gps.longitude", -11.5753822},
                                                         {"gps.altitude", 519.123},
                                                         {"gps.speed", 12.34},
                                                         {"gps.heading", 271.5},
                                                         {"gps.satellites", 14}});
}

TEST(MavlinkTelemetry, ReadsNoPositionWithoutAFixAndNothingThatIsUnknown) {
    const Bytes payload =
        from_hex("0000000000000000 9025b11c a2bc19f9 d3eb0700 ffff ffff ffff ffff 01 ff");
    expect_near(numbers_of(message_2(24, 24, payload)), {{"gps.fix", 1},
                                                         {"gps.latitude", kNotAvailable},
                                                         {"gps.longitude", kNotAvailable},
                                                         {"gps.altitude", kNotAvailable},
                                                         {"gps.speed", kNotAvailable},
                                                         {"gps.heading", kNotAvailable},
                                                         {"gps.satellites", kNotAvailable}});
}

TEST(MavlinkTelemetry, ReadsAnglesInDegrees) {
    // roll 0.5, pitch -0.25, yaw 3.0 rad.
    const Bytes payload = from_hex(
        "00000000 0000003f 000080be 00004040 00000000 00000000"
        "00000000");
    expect_near(numbers_of(message_2(30, 39, payload)), {{"attitude.roll", 28.64788976},
                                                         {"attitude.pitch", -14.32394488},
                                                         {"attitude.yaw", 171.8873385}});
}

TEST(MavlinkTelemetry, ReadsSpeedsAndANumberThatIsNoNumberIsNotAvailable) {
    // airspeed NaN, groundspeed 4.5, altitude 120, climb -1.5, heading 90, throttle 55.
    const Bytes payload = from_hex("0000c07f 00009040 0000f042 0000c0bf 5a00 3700");
    expect_near(numbers_of(message_2(74, 20, payload)), {{"hud.airspeed", kNotAvailable},
                                                         {"hud.groundspeed", 4.5},
                                                         {"hud.altitude", 120},
                                                         {"hud.climb", -1.5},
                                                         {"hud.heading", 90},
                                                         {"hud.throttle", 55}});
}

TEST(MavlinkTelemetry, AddsTheCellsOfTheFirstBattery) {
    // 1500 mAh, 25.5 degC, cells of 4.1, 4.0 and 3.9 V, 10 A, 64 %.
    const Bytes payload = from_hex(
        "dc050000 ffffffff f609 0410a00f3c0f ffffffffffffffff"
        "ffffffffffff e803 00 00 00 40");
    expect_near(numbers_of(message_2(147, 154, payload)), {{"battery.voltage", 12},
                                                           {"battery.current", 10},
                                                           {"battery.consumed", 1500},
                                                           {"battery.remaining", 64},
                                                           {"battery.temperature", 25.5}});
    Bytes second = payload;
    second[32] = 1;
    MavlinkTelemetryReader reader;
    EXPECT_TRUE(read(reader, message_2(147, 154, second)).empty());
}

/// BATTERY_STATUS with these words for cells 1 to 10 and 11 to 14.
double voltage_of(const std::vector<unsigned>& first, const std::vector<unsigned>& more) {
    Bytes payload(54);
    const auto put = [&](std::size_t at, unsigned word) {
        payload[at] = static_cast<std::uint8_t>(word);
        payload[at + 1] = static_cast<std::uint8_t>(word >> 8U);
    };
    for (std::size_t cell = 0; cell < 10; ++cell) {
        put(10 + 2 * cell, cell < first.size() ? first[cell] : 65535);
    }
    for (std::size_t cell = 0; cell < more.size(); ++cell) {
        put(41 + 2 * cell, more[cell]);
    }
    return numbers_of(message_2(147, 154, payload)).at("battery.voltage");
}

TEST(MavlinkTelemetry, AddsCells11To14) {
    const std::vector<unsigned> ten(10, 4200);
    EXPECT_NEAR(voltage_of(ten, {}), 42.0, 1e-9);
    EXPECT_NEAR(voltage_of(ten, {4200}), 46.2, 1e-9);
    EXPECT_NEAR(voltage_of(ten, {4200, 4200}), 50.4, 1e-9);
    EXPECT_NEAR(voltage_of(ten, {4200, 4200, 4200, 4200}), 58.8, 1e-9);
    // A cell that is not there is 0; ArduPilot writes 65535 there, as for the first ten.
    EXPECT_NEAR(voltage_of(ten, {4200, 65535, 65535, 65535}), 46.2, 1e-9);
    EXPECT_NEAR(voltage_of({12600}, {}), 12.6, 1e-9);
    EXPECT_NEAR(voltage_of({65534, 4466}, {}), 70.0, 1e-9);
    EXPECT_EQ(voltage_of({}, {}), kNotAvailable);
}

TEST(MavlinkTelemetry, KnowsWhichNumbersOfABatteryAreUnknown) {
    const Bytes payload = from_hex(
        "ffffffff ffffffff ff7f ffffffffffffffffffffffffffffffffffffffff"
        "ffff 00 00 00 ff");
    for (const auto& [name, value] : numbers_of(message_2(147, 154, payload))) {
        EXPECT_EQ(value, kNotAvailable) << name;
    }
}

TEST(MavlinkTelemetry, ReadsTheRadioWhoeverItIs) {
    // A SiK radio is system 51, component 68.
    const Bytes payload = from_hex("0000 0000 c8 b4 64 32 ff");
    expect_near(numbers_of(message_2(109, 185, payload, {.system = 51, .component = 68})),
                {{"radio.rssi", 200},
                 {"radio.remote_rssi", 180},
                 {"radio.noise", 50},
                 {"radio.remote_noise", kNotAvailable}});
}

TEST(MavlinkTelemetry, KeepsToOneRadio) {
    MavlinkTelemetryReader reader;
    const auto from = [&](std::uint8_t component, Duration at) {
        const Bytes bytes = message_2(109, 185, from_hex("0000 0000 c8 b4 64 32 ff"),
                                      {.system = 51, .component = component});
        return read(reader, bytes, Instant{} + at).size();
    };
    EXPECT_EQ(from(68, 0ms), 1U);
    EXPECT_EQ(from(69, 500ms), 0U);
    EXPECT_EQ(from(68, 900ms), 1U);
    EXPECT_EQ(from(69, 1900ms), 1U);
    // Whose autopilot is heard does not depend on the radio.
    EXPECT_EQ(read(reader, message_2(74, 20, Bytes(20, 1)), Instant{} + 1901ms).size(), 1U);
}

TEST(MavlinkTelemetry, KeepsToTheAutopilotOfTheFirstSystemUntilItIsSilentForASecond) {
    MavlinkTelemetryReader reader;
    const auto from = [&](std::uint8_t system, std::uint8_t component, Duration at) {
        const Bytes bytes =
            message_2(74, 20, Bytes(20, 1), {.system = system, .component = component});
        return read(reader, bytes, Instant{} + at).size();
    };
    EXPECT_EQ(from(1, 100, 0ms), 0U);
    EXPECT_EQ(from(1, 1, 1ms), 1U);
    EXPECT_EQ(from(2, 1, 2ms), 0U);
    EXPECT_EQ(from(1, 1, 900ms), 1U);
    EXPECT_EQ(from(2, 1, 1899ms), 0U);
    EXPECT_EQ(from(2, 1, 1900ms), 1U);
    EXPECT_EQ(reader.rejected().back().count, 2U);
}

TEST(MavlinkTelemetry, PassesOverMessagesWithoutValues) {
    MavlinkTelemetryReader reader;
    EXPECT_TRUE(read(reader, from_hex(kHeartbeatOfAStation)).empty());
    EXPECT_TRUE(read(reader, from_hex(kRcChannelsOfAnAutopilot)).empty());
    EXPECT_EQ(reader.skipped_bytes(), 0U);
}

TEST(MavlinkTelemetry, IsAProtocolOfValues) {
    const Protocol* protocol = find_protocol("mavlink-telemetry");
    ASSERT_NE(protocol, nullptr);
    EXPECT_FALSE(protocol->has_channels());
    EXPECT_EQ(protocol->make_value_reader({})->values().size(), 29U);
}

}  // namespace
}  // namespace tribus::test::mavlink_telemetry_test
