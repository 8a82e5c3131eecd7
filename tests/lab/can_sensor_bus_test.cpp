#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/loopback.h"
#include "tests/loopback/sensor_bus.h"
#include "tests/support/dronecan_frames.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/value_reader.h"
#include "transports/codecs/dronecan/types.h"

/// The shipped examples of the sensor bus, with only the names of the devices changed: from CAN to
/// a receiver, from sensors to CAN, and both in a row.
namespace tribus::test::can_sensor_bus_test {
namespace {

constexpr unsigned kVoltage = 0xA1;
constexpr unsigned kCurrent = 0xA2;
constexpr unsigned kTemperature = 0xA3;
constexpr std::uint8_t kTemperatureType = 0x01;
constexpr std::uint8_t kVoltageType = 0x03;
constexpr std::uint8_t kCurrentType = 0x05;
/// Slots without an answer after which no answer is expected.
constexpr int kSilentSlots = 20;

/// The message of telemetry.dbc, encoded by hand: 24 bits of mV, 24 of mA, 8 of degC from -50 on.
CanFrame battery(int millivolts, int milliamperes, int temperature) {
    const auto byte = [](int value, unsigned shift) {
        return static_cast<std::uint8_t>(static_cast<unsigned>(value) >> shift & 0xFFU);
    };
    return make_frame(
        512, {byte(millivolts, 0), byte(millivolts, 8), byte(millivolts, 16), byte(milliamperes, 0),
              byte(milliamperes, 8), byte(milliamperes, 16), byte(temperature + 50, 0)});
}
constexpr int kNoProbe = 205;
constexpr int kSilent = -1;  ///< no answer: a current has no code for a negative number

class SensorBusExample : public Loopback {
  protected:
    /// Starts an example with changes: each pair is a text in it and the replacement.
    Program& run_example(const std::string& name,
                         const std::vector<std::pair<std::string, std::string>>& changes) {
        const std::filesystem::path examples = TRIBUS_SOURCE_DIR "/config/examples";
        if (std::filesystem::exists(examples / (name + ".dbc"))) {
            std::filesystem::copy_file(examples / (name + ".dbc"), folder() / (name + ".dbc"));
        }
        std::string text = read_file(examples / (name + ".toml"));
        for (const auto& [part, by] : changes) {
            EXPECT_NE(text.find(part), std::string::npos) << part;
            for (std::size_t at = text.find(part); at != std::string::npos;
                 at = text.find(part, at + by.size())) {
                text.replace(at, part.size(), by);
            }
        }
        std::ofstream(folder() / (name + ".toml")) << text;
        return run(folder() / (name + ".toml"));
    }
    /// An emulated machine has pauses, so answers may be as late as the setting allows.
    Program& run_telemetry(const FarEnd& wire, const std::string& example = "telemetry") {
        return run_example(example, {{"/dev/ttyAMA4", wire.path()},
                                     {"\"can0\"", "\"vcan0\""},
                                     {"\"sensor\"\n\n",
                                      "\"sensor\"\nwires = \"two\"\n"
                                      "reply_within = \"3ms\"\n\n"}});
    }
    Program& run_probes(const FarEnd& wire, const std::string& interface) {
        return run_example("probes", {{"/dev/ttyAMA4", wire.path()},
                                      {"\"can0\"", "\"" + interface + "\""},
                                      {"\"receiver\"\n\n", "\"receiver\"\ndrop_after = 20\n\n"}});
    }
};

class Telemetry : public SensorBusExample {
  protected:
    /// Sends the battery's message until the receiver reads this raw value.
    testing::AssertionResult shows(const CanFrame& says, unsigned request, int raw) {
        const Bytes wanted = value_reply(request & 0xFU, raw);
        Bytes seen;
        return eventually([&] {
            node_.send(says);
            const Bytes answer = receiver_.ask(request);
            seen = answer.empty() ? seen : answer;
            return answer == wanted;
        })
                   ? testing::AssertionSuccess()
                   : testing::AssertionFailure() << testing::PrintToString(seen);
    }
    /// Checks that no request is answered, while the battery sends the message if there is one.
    testing::AssertionResult is_silent(unsigned request, const CanFrame* says = nullptr) {
        for (int slot = 0; slot < kSilentSlots; ++slot) {
            if (says != nullptr) {
                node_.send(*says);
            }
            const Bytes answer = receiver_.ask(request);
            if (!answer.empty()) {
                return testing::AssertionFailure() << testing::PrintToString(answer);
            }
        }
        return testing::AssertionSuccess();
    }

    VirtualBus bus_{"vcan0"};
    RawCan node_{"vcan0"};
    FarEnd& wire_ = device("sensors");
    Asker receiver_{wire_, FarWires::two};
    Program& program_ = run_telemetry(wire_);
};

TEST_F(Telemetry, ABatteryMessageAppearsAsVoltageCurrentAndTemperature) {
    for (const auto& [address, type] : std::map<unsigned, std::uint8_t>{
             {1, kVoltageType}, {2, kCurrentType}, {3, kTemperatureType}}) {
        EXPECT_EQ(receiver_.ask_until_answered(0x80U | address), sensor_frame(0x80U | address));
        EXPECT_EQ(receiver_.ask_until_answered(0x90U | address),
                  sensor_frame(0x90U | address, {type, 2}));
    }
    const CanFrame says = battery(25'130, 12'340, 31);
    EXPECT_TRUE(shows(says, kVoltage, 2513));     // 0.01 V
    EXPECT_TRUE(shows(says, kCurrent, 1234));     // 0.01 A
    EXPECT_TRUE(shows(says, kTemperature, 710));  // 0.1 degC from -40 on
    expect_clean_end(program_);
}

struct Extreme {
    std::string name;
    CanFrame says;
    int voltage;
    int current;
    int temperature;
};

class TelemetryExtreme : public Telemetry, public testing::WithParamInterface<Extreme> {};

INSTANTIATE_TEST_SUITE_P(
    Numbers, TelemetryExtreme,
    testing::Values(Extreme{"Zero", battery(0, 0, 0), 0, 0, 400},
                    Extreme{"HalvesGoAwayFromZero", battery(-15, 15, -1), -2, 2, 390},
                    Extreme{"LastThatFit", battery(327'670, 655'350, -40), 32'767, 65'535, 0},
                    Extreme{"FirstTooHigh", battery(327'680, 655'360, 204), 32'767, 65'535, 2440},
                    Extreme{"LastThatFitBelow", battery(-327'670, 0, -39), -32'767, 0, 10},
                    // -32768 is the code for "not available". No number is converted to it.
                    Extreme{"FirstTooLow", battery(-327'680, -1, -41), -32'767, 0, 0},
                    Extreme{"Highest", battery(0x7FFFFF, 0x7FFFFF, 204), 32'767, 65'535, 2440},
                    Extreme{"Lowest", battery(-0x800000, -0x800000, -50), -32'767, kSilent, 0}),
    [](const auto& test) { return test.param.name; });

TEST_P(TelemetryExtreme, SaturatesAndNeverWraps) {
    const auto& [name, says, voltage, current, temperature] = GetParam();
    EXPECT_TRUE(shows(battery(25'130, 12'340, 31), kVoltage, 2513));
    EXPECT_TRUE(shows(says, kVoltage, voltage));
    EXPECT_TRUE(current == kSilent ? is_silent(kCurrent, &says) : shows(says, kCurrent, current));
    EXPECT_TRUE(shows(says, kTemperature, temperature));
    expect_clean_end(program_);
}

TEST_F(Telemetry, DisappearsWhenTheMessageStopsAndComesBackWithIt) {
    EXPECT_TRUE(is_silent(kCurrent)) << "before the first message";
    EXPECT_EQ(receiver_.ask_until_answered(kVoltage), value_reply(1, -0x8000));
    for (const int volts : {12, 13}) {
        const CanFrame says = battery(volts * 1000, 1000, 20);
        EXPECT_TRUE(shows(says, kVoltage, volts * 100));
        EXPECT_TRUE(shows(says, kCurrent, 100));
        EXPECT_TRUE(shows(says, kTemperature, 600));
        EXPECT_TRUE(receiver_.ask_until(kVoltage, value_reply(1, -0x8000))) << program_.errors();
        EXPECT_TRUE(is_silent(kCurrent));
        EXPECT_TRUE(is_silent(kTemperature));
        EXPECT_EQ(receiver_.ask_until_answered(0x82), sensor_frame(0x82)) << "it is not found";
        EXPECT_EQ(receiver_.ask_until_answered(kVoltage), value_reply(1, -0x8000));
    }
    expect_clean_end(program_);
}

TEST_F(Telemetry, OnlyTheSignalThatTheMessageCallsMissingDisappears) {
    const CanFrame with = battery(12'000, 1000, 20);
    const CanFrame without = battery(12'000, 1000, kNoProbe);
    EXPECT_TRUE(shows(with, kTemperature, 600));
    EXPECT_TRUE(shows(without, kVoltage, 1200));
    EXPECT_TRUE(eventually([&] {
        node_.send(without);
        return receiver_.ask(kTemperature).empty();
    }));
    EXPECT_TRUE(is_silent(kTemperature, &without));
    EXPECT_TRUE(shows(without, kCurrent, 100));
    EXPECT_TRUE(shows(with, kTemperature, 600));
    expect_clean_end(program_);
}

void send_all(RawCan& node, const std::vector<CanFrame>& frames) {
    for (const CanFrame& frame : frames) {
        node.send(frame);
    }
}

TEST_F(SensorBusExample, DevicesOnDroneCanAppearAsSensorsAndAreNotShownWhenTheyAreSilent) {
    const VirtualBus bus("vcan0");
    RawCan node("vcan0");
    FarEnd& wire = device("sensors");
    Asker receiver(wire, FarWires::two);
    Program& program = run_telemetry(wire, "dronecan-telemetry");
    std::uint8_t transfer_id = 0;
    const auto shows = [&](unsigned request, int raw, const auto& message) {
        return eventually([&] {
            send_all(node, frames_of_message(message, 30, transfer_id++ & 31));
            return receiver.ask(request) == value_reply(request & 0xFU, raw);
        });
    };
    dronecan::BatteryInfo battery;
    battery.voltage = 16.5F;
    battery.current = 12.25F;
    EXPECT_TRUE(shows(0xA1, 1650, battery)) << program.errors();
    EXPECT_TRUE(shows(0xA2, 1225, battery));
    dronecan::EscStatus motor;
    motor.temperature = 300.25F;  // 27.1 degC
    motor.rpm = 12'345;
    EXPECT_TRUE(shows(0xA3, 671, motor));
    EXPECT_TRUE(shows(0xA4, 12'345, motor));
    dronecan::GnssFix2 fix;
    fix.sats_used = 7;
    EXPECT_TRUE(shows(0xA5, 7 << 8, fix));
    EXPECT_TRUE(receiver.ask(0xA6).empty()) << "a position without a fix";
    fix.status = dronecan::GnssFix2::kStatus3dFix;
    fix.ned_velocity = {3, 4, 0};
    EXPECT_TRUE(shows(0xA6, 500, fix));
    EXPECT_TRUE(eventually([&] { return receiver.ask(0xA6).empty(); })) << "the GPS is silent";
    expect_clean_end(program);
}

/// Reads one message of a DBC file from a bus.
class Listener {
  public:
    Listener(const std::string& interface, const std::filesystem::path& file,
             const std::string& message)
        : socket_(interface), reader_(reader_of(file, message)) {}

    using Wanted = std::function<bool(const ValueReading&)>;

    /// Waits until the latest frame has the wanted value of a signal, or kPatience is over. Calls
    /// `meanwhile` repeatedly.
    testing::AssertionResult hears(const std::string& signal, const Wanted& wanted,
                                   const std::function<void()>& meanwhile) {
        ValueReading latest;
        const bool heard = eventually([&] {
            meanwhile();
            bool found = false;
            for (const CanSight& sight : socket_.receive_all()) {
                std::vector<ValueReading> readings(reader_.values().size());
                if (reader_.take(sight.frame, Instant{}, readings)) {
                    latest = readings[place(signal)];
                    found = wanted(latest);
                }
            }
            return found;
        });
        return heard ? testing::AssertionSuccess()
                     : testing::AssertionFailure()
                           << signal << " is " << latest.number << " in state "
                           << static_cast<int>(latest.state);
    }
    testing::AssertionResult hears(
        const std::string& signal, double number, const std::function<void()>& meanwhile = [] {}) {
        return hears(
            signal,
            [=](const ValueReading& reading) {
                return reading.state == ValueReading::State::number &&
                       std::abs(reading.number - number) < 1e-6;
            },
            meanwhile);
    }
    testing::AssertionResult hears_nothing_of(const std::string& signal) {
        return hears(
            signal,
            [](const ValueReading& reading) {
                return reading.state == ValueReading::State::not_available;
            },
            [] {});
    }

  private:
    static DbcValueReader reader_of(const std::filesystem::path& file, const std::string& message) {
        const auto parsed = parse_dbc(read_file(file) + "\n");
        EXPECT_TRUE(parsed) << file;
        auto reader = make_dbc_value_reader(parsed.value(), message);
        EXPECT_TRUE(reader) << reader.error();
        return std::move(reader.value());
    }
    std::size_t place(const std::string& signal) const {
        std::size_t i = 0;
        while (i < reader_.values().size() && reader_.values()[i].name != signal) {
            ++i;
        }
        EXPECT_LT(i, reader_.values().size()) << signal;
        return i;
    }

    RawCan socket_;
    DbcValueReader reader_;
};

std::filesystem::path source(std::string_view path) {
    return std::filesystem::path(TRIBUS_SOURCE_DIR) / path;
}

TEST_F(SensorBusExample, ProbesGoOutOnCanAndAreNotAvailableWhenTheyAreGone) {
    const VirtualBus bus("vcan0");
    FarEnd& wire = device("probes");
    const std::vector<SensorString::Sensor> both{{kVoltageType, {0xFE, 0xFF}},
                                                 {kTemperatureType, {0xF4, 0x01}}};
    SensorString sensors(wire, FarWires::one, both);
    Listener first("vcan0", source("deploy/can/sensors.dbc"), "Sensor1");
    Listener second("vcan0", source("deploy/can/sensors.dbc"), "Sensor2");
    Listener chosen("vcan0", source("config/examples/probes.dbc"), "Probes");
    Program& program = run_probes(wire, "vcan0");
    for (int time = 0; time < 2; ++time) {
        EXPECT_TRUE(first.hears("available", 1)) << program.errors();
        EXPECT_TRUE(first.hears("type", kVoltageType));
        EXPECT_TRUE(first.hears("external_voltage", -0.02));
        EXPECT_TRUE(second.hears("available", 1));
        EXPECT_TRUE(second.hears("type", kTemperatureType));
        EXPECT_TRUE(second.hears("temperature", 10));
        EXPECT_TRUE(chosen.hears("Voltage", -20));
        EXPECT_TRUE(chosen.hears("Temperature", 10));
        sensors.set({both.front()});
        EXPECT_TRUE(second.hears("available", 0)) << program.errors();
        EXPECT_TRUE(chosen.hears_nothing_of("Temperature"));
        EXPECT_TRUE(chosen.hears("Voltage", -20));
        sensors.set({});
        EXPECT_TRUE(first.hears("available", 0)) << program.errors();
        EXPECT_TRUE(chosen.hears_nothing_of("Voltage"));
        sensors.set(both);
    }
    expect_clean_end(program);
}

/// Literal bytes of the layout that sensor_can.h describes, for one sensor at address 1.
TEST_F(SensorBusExample, ProbesHaveTheLayoutThatIsDescribed) {
    const VirtualBus bus("vcan0");
    FarEnd& wire = device("probes");
    const SensorString sensors(wire, FarWires::one, {{kVoltageType, {0xFE, 0xFF}}});
    RawCan watcher("vcan0");
    Program& program = run_probes(wire, "vcan0");
    std::vector<CanFrame> readings;
    EXPECT_TRUE(eventually([&] {
        for (const CanSight& sight : watcher.receive_all()) {
            if (sight.frame.id >= 0x320 && sight.frame.id <= 0x32E) {
                readings.push_back(sight.frame);
            }
        }
        return readings.size() >= 40;
    })) << program.errors();
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const CanFrame& frame = readings[i];
        ASSERT_EQ(frame.id, 0x320U);
        ASSERT_EQ(frame.length, 8);
        EXPECT_EQ(frame.data[0], kVoltageType);
        EXPECT_EQ(frame.data[1] & 0x0E, 0);
        EXPECT_EQ(frame.data[1] >> 4, static_cast<int>(i % 16)) << "the counter is wrong";
        EXPECT_EQ((Bytes{frame.data.begin() + 4, frame.data.begin() + 8}),
                  (Bytes{0xFE, 0xFF, 0xFF, 0xFF}));
    }
    expect_clean_end(program);
}

TEST_F(SensorBusExample, ABatteryOnOneBusCrossesTheSensorWireToAnotherBus) {
    const VirtualBus near("vcan0");
    const VirtualBus far("vcan1");
    FarEnd& sensors = device("sensors");
    FarEnd& probes = device("probes");
    RawCan node("vcan0");
    Listener voltage("vcan1", source("deploy/can/sensors.dbc"), "Sensor1");
    Listener current("vcan1", source("deploy/can/sensors.dbc"), "Sensor2");
    Listener temperature("vcan1", source("deploy/can/sensors.dbc"), "Sensor3");
    Program& telemetry = run_telemetry(sensors);
    Program& receiver = run_probes(probes, "vcan1");
    const Joint joint(sensors, probes, FarWires::two);
    const auto say = [&] { node.send(battery(25'130, 12'340, -7)); };
    EXPECT_TRUE(voltage.hears("external_voltage", 25.13, say))
        << telemetry.errors() << receiver.errors();
    EXPECT_TRUE(current.hears("battery_current", 12.34, say));
    EXPECT_TRUE(temperature.hears("temperature", -7, say));
    EXPECT_TRUE(voltage.hears_nothing_of("external_voltage")) << telemetry.errors();
    EXPECT_TRUE(current.hears("available", 0)) << receiver.errors();
    EXPECT_TRUE(temperature.hears("available", 0));
    EXPECT_TRUE(voltage.hears("external_voltage", 25.13, say));
    EXPECT_TRUE(current.hears("available", 1, say));
    expect_clean_end(telemetry);
    expect_clean_end(receiver);
}

}  // namespace
}  // namespace tribus::test::can_sensor_bus_test
