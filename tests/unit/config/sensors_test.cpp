#include <chrono>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"
#include "tests/unit/config/main_job.h"

/// Sensors, their types and the values that they send: limits, places and what is read.
namespace tribus::test::sensors_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

/// Without the name of the file.
Lines mistakes(std::string_view text) {
    Lines lines = mistakes_in(text, "f");
    for (std::string& line : lines) {
        line.erase(0, 2);
    }
    return lines;
}

/// The sensor begins in line 5.
std::string with_sensor(std::string_view sensor, std::string_view bus = "") {
    return "[sensor_bus.t]\ndevice = \"/dev/ttyS\"\nrole = \"sensor\"\n" + std::string(bus) +
           "[[sensor_bus.t.sensor]]\n" + std::string(sensor) + "\n";
}

TEST(ValuesOfASensor, AreAllLookedFor) {
    EXPECT_EQ(
        mistakes(with_sensor(
            "type = \"gps_status\"\nvalues = { fix = \"cells\", satellites = \"machine.lod\" }\n"
            "[values.cells]\nconstant = 6")),
        Lines{"6:40: there is no value \"machine.lod\"; did you mean \"machine.load\"?"});
}

TEST(ValueOfASensor, MayBeAFactAboutAnOutput) {
    EXPECT_EQ(mistakes(with_sensor("type = \"external_voltage\"\nscale = 1\n"
                                   "value = \"output.servos.frame_rate\"") +
                       main_job_with(10, "")),
              Lines{});
}

constexpr std::string_view kLift =
    "[sensor_type.lift]\nid = 200\nsize = 4\nunit = \"N\"\n"
    "[sensor_bus.probes]\ndevice = \"/dev/ttyB\"\nrole = \"receiver\"\n";

TEST(ValueOfASensor, MayBeTheReadingOfAnOwnType) {
    EXPECT_EQ(mistakes(with_sensor("type = \"external_voltage\"\nscale = 1\n"
                                   "value = \"probes.lift\"") +
                       std::string(kLift)),
              Lines{});
}

TEST(OwnType, HasOneFieldOfItsSizeWithItsName) {
    const Configuration configuration = loaded(kLift);
    ASSERT_EQ(configuration.sensor_types.size(), 1U);
    const SensorType& type = configuration.sensor_types[0];
    EXPECT_EQ(type.id, 200);
    EXPECT_EQ(type.size, 4);
    ASSERT_EQ(type.fields.size(), 1U);
    EXPECT_EQ(type.fields[0].name, "lift");
    EXPECT_EQ(type.fields[0].bits, 32);
    EXPECT_EQ(type.fields[0].unit, "N");
}

TEST(OwnTypes, WithOneIdAreToldWhereEachStands) {
    EXPECT_EQ(mistakes(std::string(kLift) + "[sensor_type.a]\nid = 201\n[sensor_type.b]\nid = 201\n"
                                            "[sensor_type.c]\nid = 200\n"),
              (Lines{"10:14: [sensor_type.b] has the id 201, and so has [sensor_type.a]; give one "
                     "of them another id",
                     "12:14: [sensor_type.c] has the id 200, and so has [sensor_type.lift]; give "
                     "one of them another id"}));
}

TEST(SensorBus, HasNoNameOfTheProgramsOwn) {
    EXPECT_EQ(mistakes("[sensor_bus.machine]\ndevice = \"/dev/ttyB\"\nrole = \"receiver\"\n"),
              Lines{"1:13: \"machine\" is reserved for the program's own values; give "
                    "[sensor_bus.machine] another name"});
}

TEST(SensorBus, Has115200Baud) {
    EXPECT_EQ(loaded(kLift).sensor_buses.at(0).port.line.baud, 115200U);
}

TEST(ReplyOfASensor, LeavesBeforeItIsWithheld) {
    const auto with = [](std::string_view times) {
        return mistakes(with_sensor("type = \"fuel\"\nvalue = \"machine.load\"", times));
    };
    const std::string late =
        "\"reply_after\" is not less than \"reply_within\", so no answer would be sent; allowed: "
        "less than \"reply_within\"";
    EXPECT_EQ(with("reply_after = \"999us\"\nreply_within = \"1ms\"\n"), Lines{});
    EXPECT_EQ(with("reply_within = \"1ms\"\nreply_after = \"1ms\"\n"), Lines{"5:15: " + late});
    EXPECT_EQ(with("reply_within = \"200us\"\n"), Lines{"4:16: " + late});
}

TEST(ConstantValue, IsItsNumberInItsUnit) {
    const Configuration configuration =
        loaded(std::string(kLift) + "[values.cells]\nconstant = 6.5\nunit = \"V\"\n");
    ASSERT_EQ(configuration.values.size(), 1U);
    const auto& constant = std::get<ConstantConfig>(configuration.values[0].source);
    EXPECT_EQ(constant.number, 6.5);
    EXPECT_EQ(constant.unit, "V");
}

/// [values.x] of messages of a DBC file, in line 4.
class ValuesOfAFile : public ::testing::Test {
  protected:
    Lines mistakes(const std::string& dbc, const std::string& keys) const {
        folder_.write("bus.dbc", dbc);
        Lines lines = mistakes_in(
            "[sensor_bus.probes]\ndevice = \"/dev/ttyB\"\nrole = \"receiver\"\n[values.x]\n"
            "interface = \"can0\"\ndbc = \"bus.dbc\"\n" +
                keys,
            folder_ / "t.toml");
        for (std::string& line : lines) {
            line.erase(0, (folder_ / "t.toml:").size());
        }
        return lines;
    }
    TemporaryFolder folder_;
};

TEST_F(ValuesOfAFile, AreNotReadWhereItIsCut) {
    EXPECT_EQ(mistakes("BO_ 1 M: 8 A\nCM_ \"", "message = \"M\"\n"),
              Lines{"6:7: bus.dbc:2:5: text without its closing quote"});
}

TEST_F(ValuesOfAFile, AreNotReadFromASignalWithAMistake) {
    EXPECT_EQ(mistakes("BO_ 1 M: 8 A\n SG_ S : 60|8@1+ (1,0) [0|0] \"\" B\n"
                       " SG_ T : 0|8@1+ (1,0) [0|0] \"\" B\n",
                       "message = \"M\"\nsignals = { u = \"S\" }\n"),
              Lines{"8:17: signal \"S\" cannot be used because of a mistake in line 2, column 6 of "
                    "the DBC file: signal S needs 9 bytes, but message M has 8"});
}

TEST_F(ValuesOfAFile, LastAsLongAsTheTableSays) {
    folder_.write("bus.dbc", "BO_ 1 M: 8 A\n SG_ T : 0|8@1+ (1,0) [0|0] \"\" B\n");
    const auto configuration = load_configuration(
        "[sensor_bus.probes]\ndevice = \"/dev/ttyB\"\nrole = \"receiver\"\n[values.x]\n"
        "interface = \"can0\"\ndbc = \"bus.dbc\"\nmessage = \"M\"\ntimeout = \"5s\"\n",
        folder_ / "t.toml");
    ASSERT_TRUE(configuration) << format_mistake(configuration.error().front());
    EXPECT_EQ(std::get<ValueMessageConfig>(configuration->values.at(0).source).timeout, 5s);
}

}  // namespace
}  // namespace tribus::test::sensors_test
