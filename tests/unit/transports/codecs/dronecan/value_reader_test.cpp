#include "transports/codecs/dronecan/value_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/dronecan_frames.h"
#include "transports/codecs/dronecan/types.h"

namespace tribus::test::value_reader_test {
namespace {

using namespace dronecan;
using namespace std::chrono_literals;
using State = ValueReading::State;

/// A reader and its last result.
class Reader {
  public:
    explicit Reader(std::string_view message, const SourceChoice& source = {}, bool fd = false)
        : reader_(make_value_reader(message, source, fd)), readings_(reader_->values().size()) {}

    CanValueReader* operator->() { return reader_.get(); }
    /// Reads frames that come a millisecond apart. Returns the time of the message, if there is
    /// one.
    std::optional<Instant> take(const std::vector<CanFrame>& frames, Instant at = kStart) {
        std::optional<Instant> of;
        for (const CanFrame& frame : frames) {
            of = reader_->take(frame, at, readings_);
            at += 1ms;
        }
        return of;
    }
    State state(std::string_view name) const { return readings_.at(index(name)).state; }
    /// Returns the number of a value, or NaN if it has none.
    double number(std::string_view name) const {
        const ValueReading& reading = readings_.at(index(name));
        return reading.state == State::number ? reading.number : std::nan("");
    }
    std::string unit(std::string_view name) const { return reader_->values()[index(name)].unit; }

  private:
    std::size_t index(std::string_view name) const {
        const auto values = reader_->values();
        const auto found = std::ranges::find(values, name, &CanValueReader::Value::name);
        EXPECT_NE(found, values.end()) << name;
        return static_cast<std::size_t>(found - values.begin());
    }

    std::unique_ptr<CanValueReader> reader_;
    std::vector<ValueReading> readings_;
};

/// "batteryinfo" of tests/vectors/dronecan_vectors.json: its health is the code for unknown.
const std::vector<CanFrame> kBattery = frames_from(
    0x1004441E,
    {"23F9A85C204C2086", "4A505A4052A05426", "0000011FE2030006", "000000006C697026", "6F347346"});

TEST(DroneCanValueReader, TellsTheNumbersOfABattery) {
    Reader reader("uavcan.equipment.power.BatteryInfo");
    ASSERT_TRUE(reader.take(kBattery));
    EXPECT_EQ(reader.number("voltage"), 16.5);
    EXPECT_EQ(reader.unit("voltage"), "V");
    EXPECT_EQ(reader.number("current"), 12.25);
    EXPECT_EQ(reader.number("temperature"), 298);
    EXPECT_EQ(reader.unit("temperature"), "K");
    EXPECT_EQ(reader.number("remaining_capacity_wh"), 50);
    EXPECT_EQ(reader.number("state_of_charge_pct"), 68);
    EXPECT_EQ(reader.number("battery_id"), 0);
    EXPECT_EQ(reader.state("state_of_health_pct"), State::not_available);
}

TEST(DroneCanValueReader, TellsTheNumbersOfAMotor) {
    Reader reader("uavcan.equipment.esc.Status");
    // "esc_status" of the vectors.
    ASSERT_TRUE(
        reader.take(frames_from(0x10040A1F, {"0A4F00000000208B", "4C00C1D85CC7CF2B", "D50C4B"})));
    EXPECT_EQ(reader.number("rpm"), -12345);
    EXPECT_EQ(reader.number("current"), -2.5);
    EXPECT_EQ(reader.number("power_rating_pct"), 42);
    EXPECT_EQ(reader.number("esc_index"), 3);
}

TEST(DroneCanValueReader, TakesEveryFloatThatIsNoNumberForNotAvailable) {
    // "device_temperature" of the vectors, 300 K. Then an unknown temperature as libcanard and
    // pydronecan send it, after IEEE 754, and from a division by zero (docs/protocols/can.md,
    // "DroneCAN: telemetry").
    Reader reader("uavcan.equipment.device.Temperature");
    ASSERT_TRUE(reader.take(frames_from(0x18045620, {"0700B05C00C0"})));
    EXPECT_EQ(reader.number("temperature"), 300);
    int transfer_id = 0;
    for (const std::string unknown : {"FF7F", "007E", "007C", "00FC"}) {
        const std::string tail = "C" + std::to_string(++transfer_id);
        ASSERT_TRUE(reader.take(frames_from(0x18045620, {"0700" + unknown + "00" + tail})));
        EXPECT_EQ(reader.state("temperature"), State::not_available) << unknown;
        EXPECT_EQ(reader.number("device_id"), 7) << unknown;
    }
}

TEST(DroneCanValueReader, TellsWhenTheFirstFrameOfAMessageCame) {
    Reader reader("uavcan.equipment.power.BatteryInfo");
    EXPECT_EQ(reader.take(kBattery, kStart + 5s), kStart + 5s);
}

TEST(DroneCanValueReader, SaysNothingOfAMessageThatIsDamagedOrOfAnotherType) {
    Reader reader("uavcan.equipment.power.BatteryInfo");
    auto damaged = kBattery;
    damaged[2].data[3] ^= 1;
    EXPECT_FALSE(reader.take(damaged));
    EXPECT_EQ(count_named(reader->rejected(), "crc"), 1U);
    EXPECT_FALSE(reader.take(frames_of_message(CircuitStatus{}, 30, 0)));
}

CircuitStatus circuit(std::uint16_t id, float voltage) {
    CircuitStatus message;
    message.circuit_id = id;
    message.voltage = voltage;
    return message;
}

/// Sends the messages of several circuits and nodes.
class Circuits {
  public:
    explicit Circuits(const SourceChoice& source)
        : reader_("uavcan.equipment.power.CircuitStatus", source) {}
    bool hears(NodeId node, std::uint16_t id, Instant at) {
        return reader_.take(frames_of_message(circuit(id, 5), node, ++transfer_id_ & 31), at)
            .has_value();
    }
    std::uint64_t of_others() { return count_named(reader_->rejected(), "other source"); }

  private:
    Reader reader_;
    std::uint8_t transfer_id_ = 0;
};

TEST(DroneCanValueReader, HoldsOnToTheFirstOfSeveralUntilItHasBeenSilentForThreeSeconds) {
    Circuits circuits({});
    EXPECT_TRUE(circuits.hears(10, 1, kStart));
    EXPECT_FALSE(circuits.hears(10, 2, kStart + 1s)) << "another circuit of the node";
    EXPECT_FALSE(circuits.hears(11, 1, kStart + 1s)) << "another node";
    EXPECT_EQ(circuits.of_others(), 2U);
    EXPECT_TRUE(circuits.hears(10, 1, kStart + 2s));
    EXPECT_FALSE(circuits.hears(11, 1, kStart + 4999ms));
    EXPECT_TRUE(circuits.hears(11, 1, kStart + 5s));
    EXPECT_FALSE(circuits.hears(10, 1, kStart + 6s));
}

TEST(DroneCanValueReader, HearsTheChosenNodeAndInstanceOnly) {
    Circuits circuits({.node = 10, .instance = 2});
    EXPECT_FALSE(circuits.hears(10, 1, kStart));
    EXPECT_FALSE(circuits.hears(11, 2, kStart));
    EXPECT_TRUE(circuits.hears(10, 2, kStart));
    EXPECT_TRUE(circuits.hears(10, 2, kStart + 100s));
    Circuits of_any_node({.node = {}, .instance = 2});
    EXPECT_FALSE(of_any_node.hears(10, 1, kStart));
    EXPECT_TRUE(of_any_node.hears(11, 2, kStart));
}

TEST(DroneCanValueReader, BelievesOfAPositionWhatItsFixGives) {
    GnssFix2 fix;
    fix.latitude_deg_1e8 = 4'700'000'000;
    fix.height_msl_mm = 450'000;
    fix.ned_velocity = {1, 2, 3};
    fix.sats_used = 7;
    Reader reader("uavcan.equipment.gnss.Fix2");
    const auto states = [&](std::uint8_t status) {
        fix.status = status;
        EXPECT_TRUE(reader.take(frames_of_message(fix, 20, status)));
        std::vector<bool> known;
        for (const auto* name : {"sats_used", "status", "latitude_deg_1e8", "ned_velocity[0]",
                                 "height_msl_mm", "ned_velocity[2]"}) {
            known.push_back(reader.state(name) == State::number);
        }
        return known;
    };
    using Known = std::vector<bool>;
    EXPECT_EQ(states(GnssFix2::kStatusNoFix), (Known{true, true, false, false, false, false}));
    EXPECT_EQ(states(GnssFix2::kStatusTimeOnly), (Known{true, true, false, false, false, false}));
    EXPECT_EQ(states(GnssFix2::kStatus2dFix), (Known{true, true, true, true, false, false}));
    EXPECT_EQ(states(GnssFix2::kStatus3dFix), (Known{true, true, true, true, true, true}));
    EXPECT_EQ(reader.number("latitude_deg_1e8"), 4'700'000'000);
    EXPECT_EQ(reader.state("timestamp.usec"), State::not_available);
    EXPECT_EQ(reader.state("ecef_position_velocity[0].velocity_xyz[1]"), State::not_available);
}

TEST(DroneCanValueReader, WorksOutTheSpeedOverGroundOfAFix) {
    GnssFix2 fix;
    fix.ned_velocity = {3, -4, 12};
    Reader reader("uavcan.equipment.gnss.Fix2");
    ASSERT_TRUE(reader.take(frames_of_message(fix, 20, 0)));
    EXPECT_EQ(reader.state("ground_speed"), State::not_available);
    fix.status = GnssFix2::kStatus2dFix;
    ASSERT_TRUE(reader.take(frames_of_message(fix, 20, 1)));
    EXPECT_EQ(reader.number("ground_speed"), 5);
    EXPECT_EQ(reader.unit("ground_speed"), "m/s");
}

TEST(DroneCanValueReader, GivesEachItemThatAnArrayCouldHaveAPlace) {
    BatteryCells cells;
    for (const float voltage : {4.0F, 3.5F}) {
        cells.voltages.resize(cells.voltages.size() + 1);
        cells.voltages[cells.voltages.size() - 1] = voltage;
    }
    cells.index = 6;
    Reader reader("ardupilot.equipment.power.BatteryCells");
    ASSERT_TRUE(reader.take(frames_of_message(cells, 20, 0)));
    EXPECT_EQ(reader.number("voltages[0]"), 4.0);
    EXPECT_EQ(reader.number("voltages[1]"), 3.5);
    EXPECT_EQ(reader.state("voltages[2]"), State::not_available);
    EXPECT_EQ(reader.state("voltages[23]"), State::not_available);
    EXPECT_EQ(reader.number("index"), 6);
}

TEST(DroneCanValueReader, DoesNotBelieveASensorThatSaysItIsUnhealthy) {
    Rpm rpm;
    rpm.rpm = 1000;
    Reader reader("dronecan.sensors.rpm.RPM");
    ASSERT_TRUE(reader.take(frames_of_message(rpm, 20, 0)));
    EXPECT_EQ(reader.number("rpm"), 1000);
    rpm.flags = Rpm::kUnhealthy;
    ASSERT_TRUE(reader.take(frames_of_message(rpm, 20, 1)));
    EXPECT_EQ(reader.state("rpm"), State::not_available);
}

TEST(DroneCanValueReader, ReadsFramesOfCanFd) {
    Reader reader("uavcan.equipment.power.CircuitStatus", {}, true);
    EXPECT_TRUE(reader->uses_fd());
    ASSERT_TRUE(reader.take(frames_of_message(circuit(3, 12), 20, 0, true)));
    EXPECT_EQ(reader.number("voltage"), 12);
    EXPECT_FALSE(Reader("uavcan.equipment.power.CircuitStatus")->uses_fd());
}

class EveryValueMessage : public testing::TestWithParam<std::string_view> {};

TEST_P(EveryValueMessage, HasValuesOfDifferentNamesAndItsInstanceIsOneOfThem) {
    const auto reader = make_value_reader(GetParam(), {}, false);
    std::set<std::string> names;
    for (const CanValueReader::Value& value : reader->values()) {
        EXPECT_TRUE(names.insert(value.name).second) << value.name;
    }
    EXPECT_GE(names.size(), 2U);
    const std::string_view instance = instance_field(GetParam());
    if (!instance.empty()) {
        EXPECT_TRUE(names.contains(std::string(instance))) << instance;
    }
}
INSTANTIATE_TEST_SUITE_P(All, EveryValueMessage, testing::ValuesIn(kValueMessages),
                         [](const auto& parameter) {
                             const std::string_view name = parameter.param;
                             return std::string(name.substr(name.rfind('.') + 1));
                         });

}  // namespace
}  // namespace tribus::test::value_reader_test
