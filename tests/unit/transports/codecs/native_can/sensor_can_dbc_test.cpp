#include "transports/codecs/native_can/sensors_dbc.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "core/value_board.h"
#include "tests/support/dbc_maps.h"
#include "transports/codecs/dbc/value_reader.h"

namespace tribus::sensor_can_dbc_test {
namespace {

using namespace test;

DbcFile parsed(const std::string& text) {
    auto file = parse_dbc(text);
    if (!file) {
        ADD_FAILURE() << file.error().line << ": " << file.error().text;
        return {};
    }
    return std::move(*file);
}

TEST(SensorsDbc, TheShippedFileIsWhatTheProgramPrints) {
    std::ifstream file(std::filesystem::path(TRIBUS_SOURCE_DIR) / "deploy/can/sensors.dbc",
                       std::ios::binary);
    const std::string shipped{std::istreambuf_iterator<char>(file), {}};
    EXPECT_TRUE(shipped == sensor_can_dbc())
        << "write the output of tribus dbc --sensors to deploy/can/sensors.dbc";
}

TEST(SensorsDbc, HasAMessageForEachAddress) {
    const DbcFile file = parsed(sensor_can_dbc());
    ASSERT_EQ(file.messages.size(), 15U);
    EXPECT_EQ(file.messages.front().name, "Sensor1");
    EXPECT_EQ(file.messages.front().id, 0x320U);
    EXPECT_EQ(file.messages.back().name, "Sensor15");
    EXPECT_EQ(file.messages.back().id, 0x32EU);
    for (const DbcMessage& message : file.messages) {
        EXPECT_EQ(message.cycle_time, milliseconds(100)) << message.name;
        EXPECT_EQ(message.length, 8U) << message.name;
    }
}

TEST(SensorsDbc, FollowsTheIds) {
    const DbcFile file = parsed(sensor_can_dbc({.base_id = 0x1234500, .extended = true}));
    ASSERT_EQ(file.messages.size(), 15U);
    EXPECT_EQ(file.messages[14].id, 0x123450EU);
    EXPECT_TRUE(file.messages[14].extended);
}

TEST(SensorsDbc, NamesTheTypes) {
    const DbcFile file = parsed(sensor_can_dbc());
    const DbcSignal* type = file.messages.at(2).find("type");
    ASSERT_NE(type, nullptr);
    EXPECT_EQ(std::ranges::count(type->value_texts, DbcValueText{3, "external_voltage"}), 1);
    const DbcSignal* voltage = file.messages.at(2).find("external_voltage");
    ASSERT_NE(voltage, nullptr);
    EXPECT_EQ(voltage->value_texts,
              (std::vector<DbcValueText>{{.raw = -32768, .text = "NotAvailable"}}));
}

/// Sends one raw value of one type, and returns the number and unit that the DBC gives for each
/// field.
class SentReading {
  public:
    explicit SentReading(const std::string& dbc)
        : reader_(*parsed(dbc).find("Sensor1")), readings_(reader_.values().size()) {
        encoder_.use(board_);
    }

    void send(const SensorType& type, double raw) {
        board_.set(0, raw, at(0), type.id);
        const CanFrames frames = frames_of(encoder_, ChannelFrame{}, at(0));
        ASSERT_EQ(frames.size(), 1U);
        ASSERT_TRUE(reader_.take(frames[0], Instant{}, readings_));
    }
    std::size_t index(const std::string& name) const {
        const auto found = std::ranges::find(reader_.values(), name, &DbcValueReader::Value::name);
        return static_cast<std::size_t>(found - reader_.values().begin());
    }
    const ValueReading& reading(const std::string& name) const { return readings_.at(index(name)); }
    std::string unit(const std::string& name) const { return reader_.values()[index(name)].unit; }

  private:
    ValueBoard board_{{{.name = "probes.1.raw", .unit = "", .lasts = kForever}}};
    SensorCanEncoder encoder_{{.sensor_bus = "probes"}};
    DbcValueReader reader_;
    std::vector<ValueReading> readings_;
};

std::string signal_name(const SensorType& type, const SensorField& field) {
    return type.fields.size() == 1 ? type.name : type.name + "_" + field.name;
}

TEST(SensorsDbc, AnEncodedReadingHasTheNumberAndUnitOfItsType) {
    SentReading sent(sensor_can_dbc());
    const SensorTypes types;
    std::size_t checked = 0;
    for (const SensorType& type : types.all()) {
        if (type.size > 4 || type.fields.size() != 1) {
            continue;
        }
        const SensorField& field = type.fields.front();
        const std::int64_t half = std::int64_t{1} << (field.bits - 1);
        const std::int64_t least = field.least.value_or(field.is_signed ? -half : 0);
        for (const std::int64_t raw :
             {least, least + 1, least + half - 1, least + half, least + 2 * half - 1}) {
            sent.send(type, static_cast<double>(raw));
            const std::string name = signal_name(type, field);
            const auto expected = number_of(field, raw);
            const bool at_end = raw == least || raw == least + 2 * half - 1;
            if (!expected && !at_end) {
                continue;  // a code in the middle has a text but no range
            }
            ASSERT_EQ(sent.reading(name).state,
                      expected ? ValueReading::State::number : ValueReading::State::not_available)
                << name << " " << raw;
            EXPECT_NEAR(sent.reading(name).number, expected.value_or(0),
                        1e-12 * std::abs(expected.value_or(0)))
                << name << " " << raw;
            EXPECT_EQ(sent.unit(name), field.unit) << name;
            ++checked;
        }
    }
    EXPECT_GT(checked, 200U);
}

TEST(SensorsDbc, TypesOfSeveralFieldsAreReadFieldByField) {
    SentReading sent(sensor_can_dbc());
    const SensorTypes types;
    // 101325 Pa in bits 0 to 18 and 25.0 degC above them: raw 650 (docs/protocols/ibus.md, "Sensor
    // types", type 41).
    sent.send(*types.find("pressure"), 101325 + 650.0 * (1U << 19U));
    EXPECT_EQ(sent.reading("pressure_pressure").number, 101325);
    EXPECT_EQ(sent.unit("pressure_pressure"), "Pa");
    EXPECT_EQ(sent.reading("pressure_temperature").number, 25);
    EXPECT_EQ(sent.unit("pressure_temperature"), "degC");
}

TEST(SensorsDbc, SignalsOfOtherTypesAreAbsent) {
    SentReading sent(sensor_can_dbc());
    sent.send(*SensorTypes().find("temperature"), 650);
    EXPECT_EQ(sent.reading("temperature").number, 25);
    EXPECT_EQ(sent.reading("available").number, 1);
    EXPECT_EQ(sent.reading("external_voltage").state, ValueReading::State::absent);
}

}  // namespace
}  // namespace tribus::sensor_can_dbc_test
