#include "transports/codecs/native_can/sensors.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/value_board.h"
#include "tests/support/dbc_maps.h"

namespace tribus::sensor_can_test {
namespace {

using namespace test;
using Bytes = std::vector<std::uint8_t>;

// docs/protocols/ibus.md, "Sensor types"
constexpr std::uint8_t kTemperatureType = 0x01;
constexpr std::uint8_t kVoltageType = 0x03;

/// The values of [sensor_bus.probes] in the order of the configuration: reading and raw value in
/// turn.
ValueBoard board_of_probes() {
    std::vector<NamedValue> values;
    for (std::size_t address = 1; address <= kMostSensors; ++address) {
        const std::string name = "probes." + std::to_string(address);
        values.push_back({.name = name, .unit = "V", .lasts = milliseconds(500)});
        values.push_back({.name = name + ".raw", .unit = "", .lasts = milliseconds(500)});
    }
    return ValueBoard(std::move(values));
}

constexpr std::size_t raw_of_address(std::size_t address) {
    return 2 * (address - 1) + 1;
}

class SensorsOnCan : public testing::Test {
  protected:
    SensorsOnCan() { encoder_.use(board_); }

    CanFrames sent(int milliseconds_since_start) {
        return frames_of(encoder_, ChannelFrame{}, at(milliseconds_since_start));
    }

    ValueBoard board_ = board_of_probes();
    SensorCanEncoder encoder_{{.sensor_bus = "probes"}};
};

TEST_F(SensorsOnCan, AreOneFrameOfEightBytesForEachAddressThatWasEverSeen) {
    EXPECT_EQ(sent(0).size(), 0U);
    board_.set(raw_of_address(1), 650, at(0), kTemperatureType);
    board_.set(raw_of_address(15), 1260, at(0), kVoltageType);
    const CanFrames frames = sent(0);
    ASSERT_EQ(frames.size(), 2U);
    // 650 = 0x028A, 1260 = 0x04EC.
    EXPECT_EQ(frames[0], standard_frame(0x320, {0x01, 0x01, 0, 0, 0x8A, 0x02, 0, 0}));
    EXPECT_EQ(frames[1], standard_frame(0x32E, {0x03, 0x01, 0, 0, 0xEC, 0x04, 0, 0}));
}

TEST_F(SensorsOnCan, TellTheAgeOfTheReading) {
    board_.set(raw_of_address(1), 0, at(0), kTemperatureType);
    const CanFrames frames = sent(258);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(bytes_of(frames[0]), (Bytes{0x01, 0x01, 0x02, 0x01, 0, 0, 0, 0}));
}

TEST_F(SensorsOnCan, AStaleReadingIsSentAsNotAvailableWithTheAgeThatItHas) {
    board_.set(raw_of_address(1), 5, at(0), kTemperatureType);
    EXPECT_EQ(bytes_of(sent(501).at(0)), (Bytes{0x01, 0x00, 0xF5, 0x01, 5, 0, 0, 0}));
    // The counter of the second frame is 1. The age stays at its maximum.
    EXPECT_EQ(bytes_of(sent(1'000'000).at(0)), (Bytes{0x01, 0x10, 0xFF, 0xFF, 5, 0, 0, 0}));
}

TEST_F(SensorsOnCan, ASensorThatIsGoneIsSentAsNotAvailable) {
    board_.set(raw_of_address(1), 5, at(0), kTemperatureType);
    board_.remove(raw_of_address(1));
    EXPECT_EQ(bytes_of(sent(0).at(0)), (Bytes{0x01, 0x00, 0, 0, 5, 0, 0, 0}));
}

TEST_F(SensorsOnCan, HaveACounterOfTheirOwnThatComesRoundAfterFifteen) {
    board_.set(raw_of_address(1), 0, at(0), kTemperatureType);
    std::vector<int> counts;
    for (int i = 0; i < 17; ++i) {
        counts.push_back(sent(i).at(0).data[1] >> 4U);
    }
    EXPECT_EQ(counts, (std::vector{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0}));
    board_.set(raw_of_address(2), 0, at(20), kTemperatureType);
    EXPECT_EQ(sent(20).at(1).data[1] >> 4U, 0);
}

TEST_F(SensorsOnCan, CountOnWhereAnotherConfigurationTakesOver) {
    board_.set(raw_of_address(1), 0, at(0), kTemperatureType);
    sent(0);
    sent(1);
    SensorCanEncoder next({.sensor_bus = "probes"});
    next.use(board_);
    next.continue_from(encoder_);
    EXPECT_EQ(frames_of(next, ChannelFrame{}, at(2)), sent(2));
}

TEST_F(SensorsOnCan, RawValuesKeepTheirSign) {
    const auto bytes_of_raw = [&](double raw) {
        board_.set(raw_of_address(1), raw, at(0), kVoltageType);
        const Bytes bytes = bytes_of(sent(0).at(0));
        return Bytes(bytes.begin() + 4, bytes.end());
    };
    EXPECT_EQ(bytes_of_raw(-1), (Bytes{0xFF, 0xFF, 0xFF, 0xFF}));
    EXPECT_EQ(bytes_of_raw(65535), (Bytes{0xFF, 0xFF, 0, 0}));
    EXPECT_EQ(bytes_of_raw(-2147483648.0), (Bytes{0, 0, 0, 0x80}));
    EXPECT_EQ(bytes_of_raw(4294967295.0), (Bytes{0xFF, 0xFF, 0xFF, 0xFF}));
    EXPECT_EQ(bytes_of_raw(1e300), (Bytes{0xFF, 0xFF, 0xFF, 0xFF}));
    EXPECT_EQ(bytes_of_raw(-1e300), (Bytes{0, 0, 0, 0x80}));
}

TEST_F(SensorsOnCan, FillASnapshotWhenAllAddressesAnswer) {
    for (std::size_t address = 1; address <= kMostSensors; ++address) {
        board_.set(raw_of_address(address), 1, at(0), kTemperatureType);
    }
    const CanFrames frames = sent(0);
    ASSERT_EQ(frames.size(), 15U);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        EXPECT_TRUE(encoder_.sent()[i].matches(frames[i]));
    }
}

TEST_F(SensorsOnCan, AreNotSentOnABusThatTheBoardHasNot) {
    SensorCanEncoder other({.sensor_bus = "telemetry"});
    EXPECT_EQ(frames_of(other, ChannelFrame{}, at(0)).size(), 0U);
    other.use(board_);
    board_.set(raw_of_address(1), 1, at(0), kTemperatureType);
    EXPECT_EQ(frames_of(other, ChannelFrame{}, at(0)).size(), 0U);
}

SettingValues settings(std::int64_t id, bool extended) {
    SettingValues values;
    values.set("sensor_bus", std::string("probes"));
    values.set("id", id);
    values.set("extended", extended);
    return values;
}

TEST(SensorsProtocol, MovesTheIds) {
    const FrameEncoder encoder(kSensorsProtocol.make_encoder(settings(0x1234500, true)));
    ASSERT_EQ(encoder.encoder().sent().size(), 15U);
    EXPECT_EQ(encoder.encoder().sent().front(), (CanIdMatch{.id = 0x1234500, .extended = true}));
    EXPECT_EQ(encoder.encoder().sent().back(), (CanIdMatch{.id = 0x123450E, .extended = true}));
}

TEST(SensorsProtocol, RefusesIdsThatDoNotExist) {
    EXPECT_EQ(told(kSensorsProtocol.check(settings(0x7F1, false), SettingScope::output)),
              std::vector<std::string>{});
    EXPECT_EQ(told(kSensorsProtocol.check(settings(0x7F2, false), SettingScope::output)),
              std::vector<std::string>{
                  "id: 2034 is too high for 15 ids in a row of 11 bits; allowed is 0 to 2033, or "
                  "more with extended = true"});
    EXPECT_EQ(kSensorsProtocol.check(settings(0x1FFFFFF2, true), SettingScope::output).size(), 1U);
}

TEST(SensorsProtocol, IsForOutputsOnly) {
    EXPECT_EQ(told(kSensorsProtocol.check(settings(0x320, false), SettingScope::input)),
              std::vector<std::string>{
                  "sensor_bus: protocol \"sensors\" only sends; allowed: in an output; "
                  "[values.NAME] reads such messages with the DBC file that \"tribus dbc "
                  "--sensors\" prints"});
}

TEST(SensorsProtocol, NeedsTheRawValuesOfItsBusAndNoPipeline) {
    const auto uses = kSensorsProtocol.value_names(settings(0x320, false));
    ASSERT_EQ(uses.size(), 1U);
    EXPECT_EQ(uses[0].name, "probes.1.raw");
    EXPECT_EQ(uses[0].path, std::vector<std::string>{"sensor_bus"});
    EXPECT_FALSE(kSensorsProtocol.needs_pipeline(settings(0x320, false)));
}

}  // namespace
}  // namespace tribus::sensor_can_test
