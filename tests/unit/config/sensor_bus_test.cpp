#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "config/build/build.h"
#include "config/load.h"
#include "config/show/effective.h"
#include "tests/support/shell.h"
#include "tests/unit/config/main_job.h"

/// Sensor buses, their types and named values as a user writes them.
namespace tribus::test::sensor_bus_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

constexpr std::string_view kBattery = R"(BO_ 291 Battery: 8 A
 SG_ Voltage : 0|16@1+ (1,0) [0|60000] "mV" B
 SG_ Current : 16|16@1- (0.1,0) [0|0] "A" B
 SG_ Odd : 32|8@1+ (1,0) [0|0] "furlong" B
BO_ 292 Quick: 1 A
 SG_ State : 0|8@1+ (1,0) [0|0] "" B
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 60000;
BA_ "GenMsgCycleTime" BO_ 292 20;
)";

constexpr std::string_view kValues = R"([values.cells]
constant = 6
[values.battery]
interface = "can0"
dbc = "battery.dbc"
message = "Battery"
signals = { voltage = "Voltage" }
)";

class SensorBusConfiguration : public ::testing::Test {
  protected:
    SensorBusConfiguration() { folder_.write("battery.dbc", std::string(kBattery)); }

    auto load(std::string_view text) const { return load_configuration(text, folder_ / "t.toml"); }
    Configuration loaded(const std::string& text) const {
        auto configuration = load(text);
        if (!configuration) {
            ADD_FAILURE() << format_mistake(configuration.error().front());
            return {};
        }
        return *configuration;
    }
    /// Returns the mistakes as "line:column: text".
    Lines mistakes(const std::string& text) const {
        const auto configuration = load(text);
        Lines lines;
        if (!configuration) {
            for (const Mistake& mistake : configuration.error()) {
                lines.push_back(format_mistake({"f", mistake.where, mistake.text}).substr(2));
            }
        }
        return lines;
    }
    /// Returns the only mistake of a bus with one sensor, whose keys begin in line 12.
    std::string sensor_mistake(std::string_view keys) const {
        const Lines found = mistakes(std::string(kValues) + R"([sensor_bus.telemetry]
device = "/dev/ttyA"
role = "sensor"
[[sensor_bus.telemetry.sensor]]
)" + std::string(keys) + "\n");
        EXPECT_EQ(found.size(), 1U);
        return found.empty() ? "" : found.front();
    }

    test::TemporaryFolder folder_;
};

TEST_F(SensorBusConfiguration, IsAsTheUserWroteItWithEveryDefaultFilledIn) {
    const std::string text = std::string(kValues) + R"([sensor_type.lift]
id = 0x85
size = 4
signed = true
scale = 0.5
unit = "N"
[sensor_bus.telemetry]
device = "/dev/ttyA"
role = "sensor"
chain = true
[[sensor_bus.telemetry.sensor]]
type = "external_voltage"
value = "battery.voltage"
[[sensor_bus.telemetry.sensor]]
type = "gps_status"
values = { satellites = "cells" }
[[sensor_bus.telemetry.sensor]]
type = "lift"
value = "battery.Odd"
scale = 2
offset = -1
not_available = 0
[sensor_bus.probes]
device = "/dev/ttyB"
role = "receiver"
timeout = "3s"
)";
    const std::string effective = effective_toml(loaded(text));
    EXPECT_EQ(effective_toml(loaded(effective)), effective);
    for (const std::string_view line :
         {R"(sensor = [{ type = "external_voltage", value = "battery.voltage", offset = 0 })",
          R"({ type = "gps_status", values = { satellites = "cells" }, offset = 0 })",
          R"({ type = "lift", value = "battery.Odd", scale = 2, offset = -1, not_available = 0 }])",
          "chain = true\n", "reply_after = \"200us\"", "slot = \"7700us\"", "drop_after = 66",
          "signals = { voltage = \"Voltage\" }", "timeout = \"1s\"", "timeout = \"3s\"",
          "id = 133"}) {
        EXPECT_NE(effective.find(line), std::string::npos) << line << " in\n" << effective;
    }
}

TEST_F(SensorBusConfiguration, NeedsNoPipeline) {
    EXPECT_EQ(mistakes("[sensor_bus.probes]\ndevice = \"/dev/ttyB\"\nrole = \"receiver\"\n"),
              Lines{});
}

TEST_F(SensorBusConfiguration, TakesThreeCyclesOfAMessageForStale) {
    const Configuration configuration = loaded(
        "[values.quick]\ninterface = \"can0\"\ndbc = \"battery.dbc\"\nmessage = \"Quick\"\n"
        "[sensor_bus.probes]\ndevice = \"/dev/ttyB\"\nrole = \"receiver\"\n");
    ASSERT_EQ(configuration.values.size(), 1U);
    EXPECT_EQ(std::get<ValueMessageConfig>(configuration.values[0].source).timeout, 60ms);
}

TEST_F(SensorBusConfiguration, NamesTheValueThatWasMeant) {
    EXPECT_EQ(sensor_mistake("type = \"external_voltage\"\nvalue = \"battery.voltag\""),
              "13:9: there is no value \"battery.voltag\"; did you mean \"battery.voltage\"?");
    EXPECT_EQ(sensor_mistake("type = \"fuel\"\nvalue = \"machine.lod\""),
              "13:9: there is no value \"machine.lod\"; did you mean \"machine.load\"?");
}

TEST_F(SensorBusConfiguration, RefusesUnitsThatDoNotFit) {
    EXPECT_EQ(sensor_mistake("type = \"external_voltage\"\nvalue = \"battery.Current\""),
              "13:9: \"battery.Current\" is in \"A\", but this sensor sends \"V\"; add scale = N, "
              "the factor for the value (scale = 1: unchanged)");
    EXPECT_EQ(sensor_mistake("type = \"external_voltage\"\nvalue = \"battery.Odd\""),
              "13:9: \"battery.Odd\" is in \"furlong\", an unknown unit, but this sensor sends "
              "\"V\"; add scale = N, the factor for the value (scale = 1: unchanged)");
}

TEST_F(SensorBusConfiguration, WantsBothCoordinatesOfAPosition) {
    EXPECT_EQ(sensor_mistake("type = \"gps_full\"\nvalues = { latitude = \"cells\" }"),
              "11:1: \"gps_full\" sends a position, and \"longitude\" of it would be 0; latitude "
              "and longitude are needed, both");
    EXPECT_EQ(sensor_mistake("type = \"gps_full\"\nvalues = { longitude = \"cells\" }"),
              "11:1: \"gps_full\" sends a position, and \"latitude\" of it would be 0; latitude "
              "and longitude are needed, both");
    EXPECT_EQ(sensor_mistake("type = \"gps_full\"\nvalues = { satellites = \"cells\" }"),
              "11:1: \"gps_full\" sends a position, and both of it would be 0; latitude and "
              "longitude are needed, both");
    EXPECT_EQ(mistakes(std::string(kValues) + R"([sensor_bus.telemetry]
device = "/dev/ttyA"
role = "sensor"
sensor = [{ type = "gps_full", values = { latitude = "cells", longitude = "cells" } }]
)"),
              Lines{});
}

TEST_F(SensorBusConfiguration, NamesTheTypeAndTheFieldThatWereMeant) {
    const std::string type = sensor_mistake("type = \"external_voltge\"\nvalue = \"cells\"");
    EXPECT_EQ(type.substr(0, 87),
              "12:8: \"external_voltge\" is not a sensor type; did you mean \"external_voltage\"? "
              "allowed:");
    EXPECT_EQ(sensor_mistake("type = \"gps_status\"\nvalues = { satelites = \"cells\" }"),
              "13:12: type \"gps_status\" has no field \"satelites\"; did you mean "
              "\"satellites\"? Allowed: \"fix\", \"satellites\"");
    EXPECT_EQ(sensor_mistake("type = \"gps_status\"\nvalue = \"cells\""),
              "13:1: type \"gps_status\" has 2 fields, so \"value\" is ambiguous; allowed: values "
              "= { fix = \"...\" }");
    EXPECT_EQ(sensor_mistake("type = \"fuel\""),
              "11:1: sensor 1 of [sensor_bus.telemetry] lacks \"value\"; required: the name of the "
              "value that it sends");
}

TEST_F(SensorBusConfiguration, RefusesKeysOfTheOtherRole) {
    EXPECT_EQ(mistakes("[sensor_bus.probes]\ndevice = \"/dev/ttyB\"\nrole = \"receiver\"\n"
                       "chain = true\nreply_after = \"1ms\"\n"),
              (Lines{"4:1: \"chain\" is for role \"sensor\"; leave it out",
                     "5:1: \"reply_after\" is for role \"sensor\"; leave it out"}));
    EXPECT_EQ(mistakes("[sensor_bus.t]\ndevice = \"/dev/ttyB\"\nrole = \"sensor\"\n"
                       "slot = \"8ms\"\n[[sensor_bus.t.sensor]]\ntype = \"fuel\"\n"
                       "value = \"machine.load\"\n"),
              Lines{"4:1: \"slot\" is for role \"receiver\"; leave it out"});
}

TEST_F(SensorBusConfiguration, WantsSensorsAndRoomForThem) {
    EXPECT_EQ(mistakes("[sensor_bus.t]\ndevice = \"/dev/ttyB\"\nrole = \"sensor\"\n"),
              Lines{"1:1: [sensor_bus.t] has no sensors; required with role \"sensor\": "
                    "[[sensor_bus.t.sensor]], each with \"type\" and \"value\""});
    const std::string two =
        "sensor = [{ type = \"fuel\", value = \"machine.load\" }, "
        "{ type = \"fuel\", value = \"machine.load\" }]\n";
    const std::string bus = "[sensor_bus.t]\ndevice = \"/dev/ttyB\"\nrole = \"sensor\"\n";
    EXPECT_EQ(mistakes(bus + "address = 14\n" + two), Lines{});
    EXPECT_EQ(mistakes(bus + "address = 15\n" + two),
              Lines{"5:54: [sensor_bus.t] has 2 sensors from address 15 on; allowed: addresses up "
                    "to 15, so at most 1"});
}

TEST_F(SensorBusConfiguration, SharesItsDeviceOnlyWithAnInputAndOnlyAsSensor) {
    const std::string job(main_job_with(3, "device = \"/dev/ttyX\""));
    const std::string sensor =
        "role = \"sensor\"\nsensor = [{ type = \"fuel\", value = "
        "\"machine.load\" }]\n";
    EXPECT_EQ(mistakes(job + "[sensor_bus.t]\ndevice = \"/dev/ttyX\"\n" + sensor), Lines{});
    const std::string refused =
        "one device serves at most one input and one output, or one input and one sensor bus with "
        "role \"sensor\"";
    EXPECT_EQ(mistakes(job + "[sensor_bus.t]\ndevice = \"/dev/ttyB\"\n" + sensor),
              Lines{"11:10: device \"/dev/ttyB\" is already used by [output.servos] in line 6; " +
                    refused});
    EXPECT_EQ(mistakes(job + "[sensor_bus.t]\ndevice = \"/dev/ttyX\"\nrole = \"receiver\"\n"),
              Lines{"11:10: device \"/dev/ttyX\" is already used by [input.receiver] in line 3; " +
                    refused});
}

TEST_F(SensorBusConfiguration, RefusesNamesThatCouldNotBeToldApart) {
    const std::string probes = "[sensor_bus.probes]\ndevice = \"/dev/ttyB\"\nrole = \"receiver\"\n";
    EXPECT_EQ(mistakes(probes + "[values.probes]\nconstant = 1\n"),
              Lines{"4:9: \"probes\" is also the name of a sensor bus, so their values would have "
                    "the same names; give [values.probes] another name"});
    EXPECT_EQ(mistakes(probes + "[values.machine]\nconstant = 1\n"),
              Lines{"4:9: \"machine\" is reserved for the program's own values; give "
                    "[values.machine] another name"});
    EXPECT_EQ(mistakes(probes + "[sensor_type.a]\nid = 200\n[sensor_type.b]\nid = 200\n"),
              Lines{"6:14: [sensor_type.b] has the id 200, and so has [sensor_type.a]; give one of "
                    "them another id"});
}

/// Lacks the name of the message, which would be in line 7.
const std::string kMessageOfABus =
    "[sensor_bus.probes]\ndevice = \"/dev/ttyB\"\nrole = \"receiver\"\n"
    "[values.x]\ninterface = \"can0\"\ndbc = \"battery.dbc\"\n";

TEST_F(SensorBusConfiguration, SaysWhatIsWrongWithAMessage) {
    EXPECT_EQ(mistakes(kMessageOfABus + "message = \"Batery\"\n").size(), 1U);
    EXPECT_EQ(mistakes(kMessageOfABus + "message = \"Batery\"\n").front().substr(0, 5), "7:11:");
    EXPECT_EQ(mistakes(kMessageOfABus),
              Lines{"4:1: [values.x] lacks \"message\"; required: \"constant\", or \"interface\" "
                    "with either \"dbc\" and \"message\" or \"dronecan\", or \"protocol\" with "
                    "\"device\""});
    EXPECT_EQ(mistakes(kMessageOfABus + "message = \"Battery\"\nsignals = { u = \"Voltge\" }\n"),
              Lines{"8:17: message Battery has no signal \"Voltge\"; did you mean \"Voltage\"? "
                    "Allowed: \"Voltage\", \"Current\", \"Odd\""});
    EXPECT_EQ(mistakes(kMessageOfABus + "message = \"Battery\"\nconstant = 1\n").size(), 3U);
}

TEST_F(SensorBusConfiguration, SaysWhereTheFileOfAMessageIsWrong) {
    folder_.write("battery.dbc",
                  "BO_ 291 Battery: 8 A\n SG_ Voltage : 0|16@1+ (1,0 [0|0] \"\" B\n");
    const Lines found = mistakes(kMessageOfABus + "message = \"Battery\"\n");
    ASSERT_EQ(found.size(), 1U);
    EXPECT_TRUE(
        found.front().starts_with("7:11: battery.dbc: message \"Battery\" cannot be used "
                                  "because of a mistake in line 2, column 29 of the DBC "
                                  "file: "))
        << found.front();
}

TEST_F(SensorBusConfiguration, SaysWhatIsWrongWithTheNamesOfSignals) {
    const std::string battery = kMessageOfABus + "message = \"Battery\"\n";
    EXPECT_EQ(mistakes(battery + "signals = { Current = \"Voltage\" }\n"),
              Lines{"8:13: \"Current\" is itself a signal of Battery; give \"Voltage\" another "
                    "name"});
    EXPECT_EQ(mistakes(battery + "signals = \"Voltage\"\n"),
              Lines{"8:11: \"signals\" is \"Voltage\"; allowed: a table, { NAME = the name of a "
                    "signal in quotes }"});
    EXPECT_EQ(mistakes(battery + "signals = { u = 1 }\n"),
              Lines{"8:17: \"u\" is 1; allowed: the name of a signal in quotes"});
    EXPECT_EQ(mistakes(battery + "signals = { u = \"\" }\n"),
              Lines{"8:17: \"u\" is \"\"; allowed: the name of a signal in quotes"});
}

TEST_F(SensorBusConfiguration, SaysWhatIsWrongWithASensor) {
    EXPECT_EQ(sensor_mistake("type = \"fuel\"\nvalue = \"cells\"\nvalues = { fuel = \"cells\" }"),
              "14:1: \"values\" and \"value\" are both given; leave one of them out");
    EXPECT_EQ(sensor_mistake("type = \"gps_status\"\nvalues = \"cells\""),
              "13:10: \"values\" is \"cells\"; allowed: a table, { NAME = the name of a value in "
              "quotes }");
    EXPECT_EQ(mistakes("[sensor_bus.t]\ndevice = \"/dev/ttyB\"\nrole = \"sensor\"\n"
                       "sensor = [\"fuel\"]\n"),
              Lines{"4:11: sensor 1 of [sensor_bus.t] is \"fuel\"; allowed: a table with \"type\" "
                    "and \"value\""});
    EXPECT_EQ(mistakes("[sensor_bus.t]\ndevice = \"/dev/ttyB\"\nrole = \"receiver\"\n"
                       "[sensor_type.lift]\nid = 200\nscale = 0\n"),
              Lines{"6:9: \"scale\" is 0, so every number would be the same; allowed: any other "
                    "number"});
}

TEST_F(SensorBusConfiguration, MissesNoPipelineForAnOutputThatMayCarryValuesOnly) {
    const std::string bus =
        "[sensor_bus.probes]\ndevice = \"/dev/ttyB\"\nrole = \"receiver\"\n"
        "[output.bus]\nprotocol = \"dbc\"\ninterface = \"can0\"\n"
        "dbc = \"battery.dbc\"\n[output.bus.signals.Battery]\n";
    EXPECT_EQ(mistakes(bus + "Voltage = { from = \"probes.1\" }\n"), Lines{});
    EXPECT_EQ(mistakes(bus + "Voltage = { from = \"probes.1\", nonsense = 1 }\n").size(), 1U);
    EXPECT_EQ(mistakes(bus + "Voltage = { from = \"probe.1\" }\n"),
              Lines{"9:20: there is no value \"probe.1\"; did you mean \"probes.1\"?"});
}

TEST_F(SensorBusConfiguration, CarriesNoValuesWhereNothingAsksForThem) {
    const Configuration plain = *load(main_job_with(10, ""));
    const auto engine = build_engine(plain);
    EXPECT_EQ(build_value_engine(plain, *engine), nullptr);
}

}  // namespace
}  // namespace tribus::test::sensor_bus_test
