#include <csignal>

#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"
#include "tests/loopback/recorded_sensors.h"
#include "tests/loopback/sensor_bus.h"

/// The built program on sensor buses over ptys. A request without an answer is repeated, as
/// receivers do, so a busy machine only makes these tests slower.
namespace tribus::test::sensor_bus_test {
namespace {

constexpr unsigned kValueOf1 = 0xA1;
constexpr unsigned kValueOf2 = 0xA2;
// docs/protocols/ibus.md, "Sensor types"
constexpr std::uint8_t kSpeed = 0x02;
constexpr std::uint8_t kExternalVoltage = 0x03;

std::string wires_line(FarWires wires) {
    return wires == FarWires::one ? "wires = \"one\"\n" : "wires = \"two\"\n";
}

std::string sensor(const std::string& type, const std::string& value) {
    return "[[sensor_bus.telemetry.sensor]]\ntype = \"" + type + "\"\nvalue = \"" + value + "\"\n";
}

/// The program as sensors at @sensors. The tables of its sensors follow.
std::string telemetry(FarWires wires, const std::string& more = "") {
    return "[sensor_bus.telemetry]\ndevice = \"@sensors\"\nrole = \"sensor\"\n" +
           wires_line(wires) + more;
}

std::string constant(const std::string& name, const std::string& number, const std::string& unit) {
    return "[values." + name + "]\nconstant = " + number + "\nunit = \"" + unit + "\"\n";
}

class SensorBus : public Loopback, public testing::WithParamInterface<FarWires> {
  protected:
    FarEnd& wire_ = device("sensors");
    Asker receiver_{wire_, GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Wires, SensorBus, testing::Values(FarWires::one, FarWires::two),
                         [](const auto& wires) {
                             return wires.param == FarWires::one ? "one" : "two";
                         });

TEST_P(SensorBus, AnswersTheRecordedReceiverAsTheRecordedSensorsByteForByte) {
    Program& program = run(write_config(telemetry(GetParam()) + std::string(kRecordedSensors)));
    // The receiver takes 7.7 ms of real time for each exchange.
    constexpr std::size_t kExchanges = 400;
    for (const Capture capture : captures()) {
        expect_recorded_answers(receiver_,
                                recorded_exchanges(kExchanges / captures().size(), capture));
    }
    expect_clean_end(program);
}

TEST_P(SensorBus, IsFoundAndTellsItsTypes) {
    Program& program = run(write_config(
        constant("cells", "-1.5", "V") + constant("motor", "60", "degC") + telemetry(GetParam()) +
        sensor("external_voltage", "cells") + sensor("temperature", "motor")));
    EXPECT_EQ(receiver_.ask_until_answered(0x81), sensor_frame(0x81));
    EXPECT_EQ(receiver_.ask_until_answered(0x91), sensor_frame(0x91, {kExternalVoltage, 2}));
    EXPECT_EQ(receiver_.ask_until_answered(0x82), sensor_frame(0x82));
    EXPECT_EQ(receiver_.ask_until_answered(0x92), sensor_frame(0x92, {0x01, 2}));
    EXPECT_EQ(receiver_.ask(0x83), Bytes{});
    EXPECT_EQ(receiver_.ask_until_answered(kValueOf1), value_reply(1, -150));
    EXPECT_EQ(receiver_.ask_until_answered(kValueOf2), value_reply(2, 1000));
    expect_clean_end(program);
}

TEST_P(SensorBus, TakesTheFirstDiscoveredAddressInADaisyChain) {
    Program& program =
        run(write_config(constant("cells", "1", "V") + telemetry(GetParam(), "chain = true\n") +
                         sensor("external_voltage", "cells")));
    EXPECT_EQ(receiver_.ask(kValueOf1), Bytes{});
    EXPECT_EQ(receiver_.ask_until_answered(0x82), sensor_frame(0x82));
    EXPECT_EQ(receiver_.ask(kValueOf1), Bytes{});
    EXPECT_EQ(receiver_.ask(0x83), Bytes{});
    EXPECT_EQ(receiver_.ask_until_answered(kValueOf2), value_reply(2, 100));
    expect_clean_end(program);
}

/// The servo and sensor ports of a receiver are joined at one UART: each slot has a servo frame and
/// then a request.
TEST_P(SensorBus, SharesItsDeviceWithServoFrames) {
    ServoBank servos(device("servos"));
    Program& program = run(write_config(R"(
[input.receiver]
protocol = "ibus"
device   = "@sensors"
timeout  = "5s"

[output.servos]
protocol = "sbus"
device   = "@servos"

[pipeline.main]
from = "receiver"
to   = "servos"
)" + constant("cells", "3.7", "V") + telemetry(GetParam()) +
                                        sensor("external_voltage", "cells")));
    for (const int first_us : {1100, 1900}) {
        receiver_.send_before(ibus_bytes(sticks_with_first(first_us)));
        std::vector<SbusSight> seen;
        EXPECT_TRUE(eventually([&] {
            EXPECT_EQ(receiver_.ask_until_answered(kValueOf1), value_reply(1, 370));
            seen = servos.listen();
            return !seen.empty() && seen.back().good() && seen.back().raw[0] == sbus_raw(first_us);
        })) << program.errors();
    }
    for (int slot = 0; slot < 100; ++slot) {
        ASSERT_EQ(receiver_.ask_until_answered(kValueOf1), value_reply(1, 370));
        for (const SbusSight& sight : servos.listen()) {
            ASSERT_TRUE(sight.good());
            ASSERT_EQ(sight.raw[0], sbus_raw(1900));
        }
    }
    EXPECT_EQ(receiver_.strays(), 0U);
    EXPECT_EQ(servos.strays(), 0U);
    expect_clean_end(program);
}

TEST_P(SensorBus, AnswersWithOtherSensorsAfterAReload) {
    const auto config = [&](const std::string& volts, const std::string& more) {
        return write_config(constant("cells", volts, "V") + telemetry(GetParam()) +
                            sensor("external_voltage", "cells") + more);
    };
    Program& program = run(config("1", ""));
    EXPECT_EQ(receiver_.ask_until_answered(kValueOf1), value_reply(1, 100));
    EXPECT_EQ(receiver_.ask(kValueOf2), Bytes{});
    config("2", sensor("battery_current", "cells") + "scale = -10\noffset = 25\n");
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reloaded"));
    EXPECT_EQ(receiver_.ask_until_answered(kValueOf1), value_reply(1, 200));
    EXPECT_EQ(receiver_.ask_until_answered(kValueOf2), value_reply(2, 500));
    EXPECT_EQ(receiver_.ask_until_answered(0x92), sensor_frame(0x92, {0x05, 2}));
    expect_clean_end(program);
}

TEST_P(SensorBus, GoesOnAfterItsDeviceWasPulledAndPluggedIn) {
    Program& program = run(write_config(constant("cells", "1", "V") + telemetry(GetParam()) +
                                        sensor("external_voltage", "cells")));
    EXPECT_EQ(receiver_.ask_until_answered(kValueOf1), value_reply(1, 100));
    wire_.pull();
    EXPECT_TRUE(program.says("sensors: is gone"));
    wire_.plug_in();
    EXPECT_TRUE(program.says("sensors: is back"));
    EXPECT_EQ(receiver_.ask_until_answered(kValueOf1), value_reply(1, 100));
    expect_clean_end(program);
}

/// The program is the receiver of the sensors at @probes. It passes their values on at @sensors,
/// where the test reads them.
class ReceiverBus : public Loopback, public testing::WithParamInterface<FarWires> {
  protected:
    std::string config(const std::string& more = "") {
        return write_config("[sensor_bus.probes]\ndevice = \"@probes\"\nrole = \"receiver\"\n" +
                            wires_line(GetParam()) + more + telemetry(FarWires::two) +
                            sensor("external_voltage", "probes.external_voltage") +
                            sensor("rotation_speed", "probes.rotation_speed"));
    }
    FarEnd& probes_ = device("probes");
    SensorString sensors_{
        probes_, GetParam(), {{kSpeed, {0x10, 0x27}}, {kExternalVoltage, {0xFF, 0xFF}}}};
    Asker teller_{device("sensors"), FarWires::two};
};

INSTANTIATE_TEST_SUITE_P(Wires, ReceiverBus, testing::Values(FarWires::one, FarWires::two),
                         [](const auto& wires) {
                             return wires.param == FarWires::one ? "one" : "two";
                         });

TEST_P(ReceiverBus, FindsTheSensorsAndReadsThemInTheirUnits) {
    Program& program = run(config());
    EXPECT_TRUE(program.says("sensor bus probes: address 1 is rotation speed"));
    EXPECT_TRUE(program.says("sensor bus probes: address 2 is external voltage"));
    EXPECT_TRUE(teller_.ask_until(kValueOf1, value_reply(1, -1)));
    EXPECT_TRUE(teller_.ask_until(kValueOf2, value_reply(2, 10'000)));
    sensors_.set({{kSpeed, {0xFF, 0xFF}}, {kExternalVoltage, {0xD2, 0x04}}});
    EXPECT_TRUE(teller_.ask_until(kValueOf1, value_reply(1, 1234)));
    EXPECT_TRUE(teller_.ask_until(kValueOf2, value_reply(2, 65'535)));
    EXPECT_EQ(sensors_.strays(), 0U);
    EXPECT_GE(sensors_.asked(0xF0), 1U) << "no power-up frame was sent";
    EXPECT_GE(sensors_.asked(0x83), 1U) << "the program does not look for further sensors";
    expect_clean_end(program);
}

TEST_P(ReceiverBus, FindsASensorThatComesLater) {
    sensors_.set({});
    Program& program = run(config());
    EXPECT_TRUE(program.says("sensor bus probes: no sensor replies yet"));
    EXPECT_TRUE(teller_.ask_until(kValueOf1, value_reply(1, -0x8000)));
    EXPECT_EQ(teller_.ask(kValueOf2), Bytes{}) << "a speed cannot say \"not available\"";
    sensors_.set({{kExternalVoltage, {0x00, 0x00}}});
    EXPECT_TRUE(teller_.ask_until(kValueOf1, value_reply(1, 0)));
    sensors_.set({{kExternalVoltage, {0x00, 0x00}}, {kSpeed, {0x07, 0x00}}});
    EXPECT_TRUE(teller_.ask_until(kValueOf2, value_reply(2, 7)));
    expect_clean_end(program);
}

TEST_P(ReceiverBus, GoesOnAfterItsDeviceWasPulledAndPluggedIn) {
    Program& program = run(config());
    EXPECT_TRUE(teller_.ask_until(kValueOf2, value_reply(2, 10'000)));
    sensors_.pull();
    EXPECT_TRUE(program.says("probes: is gone"));
    EXPECT_TRUE(teller_.ask_until(kValueOf1, value_reply(1, -0x8000)));
    sensors_.plug_in();
    EXPECT_TRUE(program.says("probes: is back"));
    EXPECT_TRUE(teller_.ask_until(kValueOf1, value_reply(1, -1)));
    EXPECT_TRUE(teller_.ask_until(kValueOf2, value_reply(2, 10'000)));
    expect_clean_end(program);
}

TEST_P(ReceiverBus, DropsSensorsThatAnswerNoMoreAndTheirValues) {
    Program& program = run(config("drop_after = 40\ntimeout = \"60s\"\n"));
    EXPECT_TRUE(teller_.ask_until(kValueOf1, value_reply(1, -1)));
    sensors_.set({{kSpeed, {0x10, 0x27}}});
    EXPECT_TRUE(program.says("sensor bus probes: address 2, external voltage, is gone"));
    EXPECT_TRUE(teller_.ask_until(kValueOf1, value_reply(1, -0x8000)));
    sensors_.set({});
    EXPECT_TRUE(program.says("sensor bus probes: address 1, rotation speed, is gone"));
    expect_clean_end(program);
}

/// Removes the log lines that a machine under load may add: replies come late, and on one wire so
/// does the request that comes back, which then looks like an answer of the address behind the last
/// sensor.
std::string without_what_is_late(const std::string& log) {
    std::istringstream lines(log);
    std::string rest;
    for (std::string line; std::getline(lines, line);) {
        if (line.find("replies not sent because they were late") == std::string::npos &&
            line.find("sensor bus probes: a sensor at address 3 answers") == std::string::npos &&
            line.find("sensor bus probes: address 3 no longer answers") == std::string::npos) {
            rest += line + "\n";
        }
    }
    return rest;
}

class BothRoles : public Loopback, public testing::WithParamInterface<FarWires> {};

INSTANTIATE_TEST_SUITE_P(Wires, BothRoles, testing::Values(FarWires::one, FarWires::two),
                         [](const auto& wires) {
                             return wires.param == FarWires::one ? "one" : "two";
                         });

TEST_P(BothRoles, FindEachOtherInOneProgramAndSayNothingWhileAllIsWell) {
    FarEnd& sensors = device("sensors");
    FarEnd& probes = device("probes");
    Asker teller(device("told"), FarWires::two);
    Program& program = run(write_config(
        constant("cells", "-3.7", "V") + constant("motor", "-12.34", "degC") +
        telemetry(GetParam()) + sensor("external_voltage", "cells") +
        sensor("temperature", "motor") +
        "[sensor_bus.probes]\ndevice = \"@probes\"\nrole = \"receiver\"\n" +
        "drop_after = 10000\ntimeout = \"60s\"\n" + wires_line(GetParam()) +
        "[sensor_bus.told]\ndevice = \"@told\"\nrole = \"sensor\"\nwires = \"two\"\n" +
        "[[sensor_bus.told.sensor]]\ntype = \"external_voltage\"\nvalue = \"probes.1\"\n" +
        "[[sensor_bus.told.sensor]]\ntype = \"temperature\"\nvalue = \"probes.temperature\"\n"));
    const Joint joint(sensors, probes, GetParam());
    EXPECT_TRUE(program.says(
        "sensor bus telemetry: a receiver sends requests; sensors at addresses 1 to 2"));
    EXPECT_TRUE(program.says("sensor bus probes: address 1 is external voltage"));
    EXPECT_TRUE(program.says("sensor bus probes: address 2 is temperature"));
    EXPECT_TRUE(teller.ask_until(kValueOf1, value_reply(1, -370)));
    EXPECT_TRUE(teller.ask_until(kValueOf2, value_reply(2, 277)));  // -12.34 + 40, by 0.1
    EXPECT_TRUE(
        program.says("sensor bus told: a receiver sends requests; sensors at addresses 1 to 2"));
    // Frames that come back late on one wire look altered, but not on each turn.
    EXPECT_TRUE(eventually([&] {
        const std::string before = without_what_is_late(program.errors());
        for (int slot = 0; slot < 100; ++slot) {
            EXPECT_EQ(teller.ask_until_answered(kValueOf1), value_reply(1, -370));
            EXPECT_EQ(teller.ask_until_answered(kValueOf2), value_reply(2, 277));
        }
        return without_what_is_late(program.errors()) == before;
    })) << program.errors();
    expect_clean_end(program);
}

struct Mistake {
    std::string config;
    std::string message;
};

class WrongSensorBus : public Loopback, public testing::WithParamInterface<Mistake> {};

INSTANTIATE_TEST_SUITE_P(
    Mistakes, WrongSensorBus,
    testing::Values(
        Mistake{"[sensor_bus.x]\ndevice = \"@sensors\"\n", ":1:1: [sensor_bus.x] lacks \"role\""},
        Mistake{"[sensor_bus.x]\ndevice = \"@sensors\"\nrole = \"sensor\"\n",
                "[sensor_bus.x] has no sensors"},
        Mistake{
            telemetry(FarWires::two) + sensor("external_votlage", "machine.supply"),
            ":6:8: \"external_votlage\" is not a sensor type; did you mean \"external_voltage\"?"},
        Mistake{telemetry(FarWires::two) + sensor("external_voltage", "machine.suply"),
                ":7:9: there is no value \"machine.suply\"; did you mean \"machine.supply\"?"},
        Mistake{telemetry(FarWires::two) + sensor("external_voltage", "machine.temperature"),
                "is in \"degC\", but this sensor sends \"V\""},
        Mistake{telemetry(FarWires::two, "drop_after = 3\n") +
                    sensor("external_voltage", "machine.supply"),
                "\"drop_after\" is for role \"receiver\"; leave it out"},
        Mistake{telemetry(FarWires::two, "reply_after = \"1ms\"\n") +
                    sensor("external_voltage", "machine.supply"),
                "\"reply_after\" is not less than \"reply_within\""},
        Mistake{telemetry(FarWires::two, "address = 15\n") +
                    sensor("external_voltage", "machine.supply") + sensor("fuel", "machine.memory"),
                "allowed: addresses up to 15"}));

TEST_P(WrongSensorBus, EndsWithTheMessage) {
    device("sensors");
    Program& program = start({"run", write_config(GetParam().config)});
    EXPECT_EQ(program.end(), 2);
    EXPECT_NE(program.errors().find(GetParam().message), std::string::npos) << program.errors();
}

}  // namespace
}  // namespace tribus::test::sensor_bus_test
