#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "config/load.h"
#include "config/show/effective.h"
#include "tests/unit/config/main_job.h"

/// Values of DroneCAN messages as a user writes them.
namespace tribus::test::dronecan_values_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

/// Returns a bus that sends a value, after the table of the value. The table's lines begin in line
/// 2.
std::string with_battery(std::string_view lines, std::string_view value = "battery.voltage") {
    return "[values.battery]\n" + std::string(lines) +
           "[sensor_bus.t]\ndevice = \"/dev/ttyA\"\nrole = \"sensor\"\n"
           "sensor = [{ type = \"external_voltage\", value = \"" +
           std::string(value) + "\" }]\n";
}
constexpr std::string_view kBattery =
    "interface = \"can0\"\ndronecan = \"uavcan.equipment.power.BatteryInfo\"\n";

/// Returns the mistakes as "line:column: text".
Lines mistakes(const std::string& text) {
    Lines lines;
    for (const std::string& mistake : mistakes_in(text, "f")) {
        lines.push_back(mistake.substr(2));
    }
    return lines;
}

TEST(DroneCanValues, NeedAnInterfaceAndAMessageOnly) {
    EXPECT_EQ(mistakes(with_battery(kBattery)), Lines{});
}

TEST(DroneCanValues, AreAsTheUserWroteThemWithEveryDefaultFilledIn) {
    const std::string text = with_battery(
        std::string(kBattery) + "node = 30\ninstance = 2\nsignals = { volts = \"voltage\" }\n",
        "battery.volts");
    const auto configuration = load_configuration(text, "f");
    ASSERT_TRUE(configuration);
    const std::string effective = effective_toml(*configuration);
    for (const std::string_view line :
         {"dronecan = \"uavcan.equipment.power.BatteryInfo\"\n", "node = 30\n", "instance = 2\n",
          "fd = false\n", "timeout = \"3s\"\n", "signals = { volts = \"voltage\" }\n"}) {
        EXPECT_NE(effective.find(line), std::string::npos) << line << " in\n" << effective;
    }
    EXPECT_EQ(effective_toml(*load_configuration(effective, "f")), effective);
}

TEST(DroneCanValues, AreConvertedToTheUnitOfTheSensorOrRefused) {
    EXPECT_EQ(mistakes(with_battery(kBattery, "battery.current")),
              Lines{"7:48: \"battery.current\" is in \"A\", but this sensor sends \"V\"; add scale "
                    "= N, the factor for the value (scale = 1: unchanged)"});
}

TEST(DroneCanValues, NameWhatWasMeant) {
    EXPECT_EQ(mistakes(with_battery(kBattery, "battery.voltag")),
              Lines{"7:48: there is no value \"battery.voltag\"; did you mean "
                    "\"battery.voltage\"?"});
    EXPECT_EQ(mistakes(with_battery(std::string(kBattery) + "signals = { u = \"curent\" }\n"))
                  .front()
                  .substr(0, 123),
              "4:17: message uavcan.equipment.power.BatteryInfo has no signal \"curent\"; did you "
              "mean \"current\"? Allowed: \"temperature\", \"v");
    const Lines unknown = mistakes(
        with_battery("interface = \"can0\"\ndronecan = \"uavcan.equipment.power.BateryInfo\"\n"));
    ASSERT_EQ(unknown.size(), 1U);
    EXPECT_EQ(unknown.front().substr(0, 5), "3:12:");
    EXPECT_NE(unknown.front().find("did you mean \"uavcan.equipment.power.BatteryInfo\"?"),
              std::string::npos)
        << unknown.front();
}

TEST(DroneCanValues, RefuseAnInstanceOfWhatANodeHasOneOf) {
    EXPECT_EQ(mistakes("[values.gps]\ninterface = \"can0\"\ndronecan = "
                       "\"uavcan.equipment.gnss.Fix2\"\ninstance = 1\n[sensor_bus.p]\n"
                       "device = \"/dev/ttyA\"\nrole = \"receiver\"\n"),
              Lines{"4:1: a node has one uavcan.equipment.gnss.Fix2 only; leave \"instance\" out"});
}

TEST(DroneCanValues, RefuseKeysOfOtherSources) {
    EXPECT_EQ(
        mistakes(with_battery(std::string(kBattery) + "message = \"Battery\"\n")),
        Lines{"4:1: \"message\" has no effect together with \"dronecan\"; leave one of them out"});
    EXPECT_EQ(
        mistakes(with_battery("constant = 12\nnode = 3\n", "battery")),
        Lines{"3:1: \"node\" has no effect together with \"constant\"; leave one of them out"});
    EXPECT_EQ(mistakes(with_battery("dronecan = \"uavcan.equipment.power.BatteryInfo\"\n")),
              Lines{"1:1: [values.battery] lacks \"interface\"; required: \"constant\", or "
                    "\"interface\" with either \"dbc\" and \"message\" or \"dronecan\", or "
                    "\"protocol\" with "
                    "\"device\""});
}

}  // namespace
}  // namespace tribus::test::dronecan_values_test
