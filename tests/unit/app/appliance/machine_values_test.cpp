#include "app/appliance/machine_values.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "tests/support/shell.h"

namespace tribus::machine_values_test {
namespace {

namespace fs = std::filesystem;

/// A tree of files like those of the kernel.
class Machine : public testing::Test {
  protected:
    void write(const std::string& path, std::string_view content) const {
        const fs::path file = fs::path(folder_ / path);
        fs::create_directories(file.parent_path());
        std::ofstream(file) << content;
    }
    MachineWatch watch() const { return MachineWatch(folder_ / ""); }
    /// Returns what a watch that starts now reads first.
    std::optional<double> seen(std::string_view name) const {
        MachineWatch fresh = watch();
        return value(fresh.look(), name);
    }
    static std::optional<double> value(const MachineValues& values, std::string_view name) {
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (kMachineFacts[i].name == name) {
                return values[i];
            }
        }
        ADD_FAILURE() << "no value " << name;
        return std::nullopt;
    }

    test::TemporaryFolder folder_;
};

TEST_F(Machine, ThatTellsNothingHasNoValues) {
    for (const auto& value : watch().look()) {
        EXPECT_EQ(value, std::nullopt);
    }
}

TEST_F(Machine, IsAsHotAsItsHottestZone) {
    write("sys/class/thermal/thermal_zone0/temp", "48312\n");
    write("sys/class/thermal/thermal_zone1/temp", "51500\n");
    write("sys/class/thermal/cooling_device0/temp", "99000\n");
    EXPECT_DOUBLE_EQ(seen("temperature").value_or(0), 51.5);
}

TEST_F(Machine, BelowZeroIsATemperatureToo) {
    write("sys/class/thermal/thermal_zone0/temp", "-12500\n");
    EXPECT_DOUBLE_EQ(seen("temperature").value_or(0), -12.5);
}

TEST_F(Machine, AZoneWithoutASensibleNumberDoesNotCount) {
    write("sys/class/thermal/thermal_zone0/temp", "-274000\n");
    write("sys/class/thermal/thermal_zone1/temp", "");
    write("sys/class/thermal/thermal_zone2/temp", "hot\n");
    fs::create_directories(folder_ / "sys/class/thermal/thermal_zone3/temp");
    EXPECT_EQ(seen("temperature"), std::nullopt);
    write("sys/class/thermal/thermal_zone4/temp", "30000\n");
    EXPECT_EQ(seen("temperature"), 30);
}

TEST_F(Machine, LoadIsTheShareOfTheTimeBetweenTwoLooks) {
    write("proc/stat", "cpu  100 0 100 700 100 0 0 0 0 0\ncpu0 1 1 1 1 1 1 1 1 1 1\n");
    MachineWatch machine = watch();
    EXPECT_EQ(value(machine.look(), "load"), std::nullopt);
    // 50 of 200 more ticks are busy, 140 idle, 10 waiting. Guest ticks are already part of user
    // ticks.
    write("proc/stat", "cpu  120 10 110 840 110 5 5 0 20 0\n");
    EXPECT_EQ(value(machine.look(), "load"), 25);
    write("proc/stat", "cpu  320 10 110 840 110 5 5 0 20 0\n");
    EXPECT_EQ(value(machine.look(), "load"), 100);
}

TEST_F(Machine, LoadIsNoneWhereTheTimeStandsStillOrGoesBackOrIsNone) {
    write("proc/stat", "cpu  100 0 100 700 100 0 0 0 0 0\n");
    MachineWatch machine = watch();
    machine.look();
    EXPECT_EQ(value(machine.look(), "load"), std::nullopt);
    write("proc/stat", "cpu  300 0 100 600 100 0 0 0 0 0\n");
    EXPECT_EQ(value(machine.look(), "load"), std::nullopt);
    write("proc/stat", "cpu  300 0 100\n");
    EXPECT_EQ(value(machine.look(), "load"), std::nullopt);
    write("proc/stat", "cpu  400 0 100 700 100 0 0 0 0 0\n");
    EXPECT_EQ(value(machine.look(), "load"), std::nullopt);
    write("proc/stat", "cpu  500 0 100 700 100 0 0 0 0 0\n");
    EXPECT_EQ(value(machine.look(), "load"), 100);
}

TEST_F(Machine, MemoryInUseIsWhatIsNotAvailable) {
    write("proc/meminfo",
          "MemTotal:        4000 kB\nMemFree:          100 kB\nMemAvailable:    3000 kB\n");
    EXPECT_EQ(seen("memory"), 25);
    write("proc/meminfo", "MemTotal:        4000 kB\n");
    EXPECT_EQ(seen("memory"), std::nullopt);
    write("proc/meminfo", "MemTotal:        0 kB\nMemAvailable:    0 kB\n");
    EXPECT_EQ(seen("memory"), std::nullopt);
}

TEST_F(Machine, TheSupplyIsTheHighestVoltageOfThoseThatAreThere) {
    write("sys/class/power_supply/BAT0/voltage_now", "12345000\n");
    write("sys/class/power_supply/AC/online", "0\n");
    write("sys/class/power_supply/AC/voltage_now", "19000000\n");
    EXPECT_DOUBLE_EQ(seen("supply").value_or(0), 12.345);
    write("sys/class/power_supply/AC/online", "1\n");
    EXPECT_DOUBLE_EQ(seen("supply").value_or(0), 19);
}

TEST_F(Machine, UndervoltageIsTheAlarmOfTheBoard) {
    write("sys/class/hwmon/hwmon0/name", "cpu_thermal\n");
    write("sys/class/hwmon/hwmon0/in0_lcrit_alarm", "1\n");
    EXPECT_EQ(seen("undervoltage"), std::nullopt);
    write("sys/class/hwmon/hwmon1/name", "rpi_volt\n");
    write("sys/class/hwmon/hwmon1/in0_lcrit_alarm", "0\n");
    EXPECT_EQ(seen("undervoltage"), 0);
    write("sys/class/hwmon/hwmon1/in0_lcrit_alarm", "1\n");
    EXPECT_EQ(seen("undervoltage"), 1);
}

TEST_F(Machine, UptimeIsInSeconds) {
    write("proc/uptime", "350735.47 234388.90\n");
    EXPECT_DOUBLE_EQ(seen("uptime").value_or(0), 350735.47);
    write("proc/uptime", "soon\n");
    EXPECT_EQ(seen("uptime"), std::nullopt);
}

TEST_F(Machine, AFileThatGoesAwayTakesItsValueWithIt) {
    write("sys/class/thermal/thermal_zone0/temp", "48000\n");
    MachineWatch machine = watch();
    EXPECT_EQ(value(machine.look(), "temperature"), 48);
    fs::remove(folder_ / "sys/class/thermal/thermal_zone0/temp");
    EXPECT_EQ(value(machine.look(), "temperature"), std::nullopt);
}

TEST(ThisMachine, TellsItsUptimeAndMemory) {
    const MachineValues values = MachineWatch().look();
    EXPECT_GT(values[5].value_or(0), 0);
    EXPECT_GT(values[2].value_or(0), 0);
}

}  // namespace
}  // namespace tribus::machine_values_test
