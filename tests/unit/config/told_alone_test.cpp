#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

/// A mistake is told without those that only follow from it.
namespace tribus::test::told_alone_test {
namespace {

/// Returns only the places, `line:column`, with a space between two.
std::string places(std::string_view text) {
    std::string result;
    for (const std::string& line : mistakes_in(text)) {
        const std::string rest = line.substr(line.find(':') + 1);
        result += (result.empty() ? "" : " ") + rest.substr(0, rest.find(": "));
    }
    return result;
}

constexpr std::string_view kIbusInput = "protocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n";
constexpr std::string_view kSbusOutput = "protocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n";
constexpr std::string_view kIbusOutput = "protocol = \"ibus\"\ndevice = \"/dev/ttyB\"\n";

/// The lines of an input and of its output, and what stands behind them and their pipeline. Where
/// both have two lines, the rest begins in line 10.
struct Job {
    std::string_view name;
    std::string_view input;
    std::string_view output;
    std::string_view rest;
    std::string_view places;
};

std::ostream& operator<<(std::ostream& out, const Job& job) {
    return out << job.name;
}

std::string text_of(const Job& job) {
    return "[input.receiver]\n" + std::string(job.input) + "[output.servos]\n" +
           std::string(job.output) + "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n" +
           std::string(job.rest) + "\n";
}

class MistakeOfAJob : public ::testing::TestWithParam<Job> {};

TEST_P(MistakeOfAJob, IsToldWithoutWhatFollowsFromIt) {
    EXPECT_EQ(places(text_of(GetParam())), GetParam().places);
}

std::string name_of(const ::testing::TestParamInfo<Job>& job) {
    return std::string(job.param.name);
}

constexpr Job kPorts[]{
    {"period_beside_a_short_timeout",
     "protocol = \"ibus\"\ndevice = \"/dev/ttyA\"\ntimeout = \"10ms\"\n",
     "protocol = \"sbus\"\ndevice = \"/dev/ttyB\"\nperiod = 5\n", "", "8:10"},
    {"device_of_the_output_beside_a_short_timeout",
     "protocol = \"ibus\"\ndevice = \"/dev/ttyA\"\ntimeout = \"10ms\"\n",
     "protocol = \"sbus\"\ndevice = 3\n", "", "7:10"},
    {"timeout_beside_a_long_period",
     "protocol = \"ibus\"\ndevice = \"/dev/ttyA\"\ntimeout = \"1ms\"\n",
     "protocol = \"sbus\"\ndevice = \"/dev/ttyB\"\nperiod = \"200ms\"\n", "", "4:11"},
    {"setting_of_an_input_whose_timeout_depends_on_it",
     "protocol = \"network\"\naddress = \"127.0.0.1:5700\"\nlink = 5\n",
     "protocol = \"sbus\"\ndevice = \"/dev/ttyB\"\nperiod = \"200ms\"\n", "", "4:8"},
    {"missing_devices_of_two_protocols", "protocol = \"ibus\"\n", "protocol = \"sbus\"\n", "",
     "1:1 3:1"},
    {"wrong_devices_of_two_protocols", "protocol = \"ibus\"\ndevice = 3\n",
     "protocol = \"sbus\"\ndevice = 3\n", "", "3:10 6:10"},
    {"baud_of_a_shared_device", "protocol = \"ibus\"\ndevice = \"/dev/ttyA\"\nbaud = 9599\n",
     "protocol = \"ibus\"\ndevice = \"/dev/ttyA\"\nbaud = 57600\n", "", "4:8"},
    {"protocol_of_a_shared_device", "protocol = \"ibuz\"\ndevice = \"/dev/ttyA\"\n",
     "protocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n", "", "2:12"},
    {"interfaces_by_another_key", "protocol = \"can\"\ndevice = \"can0\"\n",
     "protocol = \"can\"\ndevice = \"can0\"\n", "", "3:1 6:1"},
    {"missing_protocol_of_an_output", kIbusInput, "device = \"/dev/ttyB\"\n", "", "4:1"},
    {"missing_protocol_of_an_input_with_rules",
     "device = \"/dev/ttyA\"\nfailsafe_when = [{ channel = 3, below = 950 }]\n", kSbusOutput, "",
     "1:1"},
    {"misspelt_protocol_beside_a_short_period", kIbusInput,
     "protocol = \"sbuz\"\ndevice = \"/dev/ttyB\"\nperiod = \"1ms\"\n", "", "5:12"},
    {"unknown_protocol_with_keys_of_others",
     "protocol = \"fm\"\ndevice = \"/dev/ttyA\"\nslots = \"plian\"\n", kSbusOutput, "", "2:12"},
};
INSTANTIATE_TEST_SUITE_P(Ports, MistakeOfAJob, ::testing::ValuesIn(kPorts), name_of);

/// These do not hide each other.
constexpr Job kBoth[]{
    {"misspelt_protocol_and_its_setting",
     "protocol = \"ibuz\"\ndevice = \"/dev/ttyA\"\nslots = \"plian\"\n", kSbusOutput, "",
     "2:12 4:9"},
    {"protocol_with_punctuation_and_its_setting", kIbusInput,
     "protocol = \"S.BUS\"\ndevice = \"/dev/ttyB\"\nscale = 1.5\n", "", "5:12 7:9"},
    {"address_and_setting", kIbusInput,
     "protocol = \"sbus\"\naddress = \"192.0.2.7:5501\"\nscale = 1.5\n", "", "6:11 7:9"},
    {"misspelt_output_of_a_line_and_its_period", kIbusInput, kSbusOutput,
     "[gpio.a]\nline = \"A\"\nrole = \"fresh\"\noutput = \"servo\"\nperiod = \"20ms\"",
     "13:10 14:10"},
};
INSTANTIATE_TEST_SUITE_P(TwoOf, MistakeOfAJob, ::testing::ValuesIn(kBoth), name_of);

constexpr std::string_view kQuickWave =
    "[gpio.a]\nline = \"A\"\nrole = \"fresh\"\nperiod = \"20ms\"";

constexpr Job kLines[]{
    {"period_of_the_output_of_a_wave", kIbusInput,
     "protocol = \"sbus\"\ndevice = \"/dev/ttyB\"\nperiod = 5\n", kQuickWave, "7:10"},
    {"device_of_the_output_of_a_wave", kIbusInput, "protocol = \"sbus\"\ndevice = 3\n", kQuickWave,
     "6:10"},
    {"range_of_the_scale_of_the_output_of_a_wave", kIbusInput,
     "protocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
     "scale = { raw = [0, 1000], us = [0, 2001] }\n",
     kQuickWave, "7:9"},
    {"slope_of_the_scale_of_the_output_of_a_wave", kIbusInput,
     "protocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
     "scale = { raw = [0, 2000], us = [1000, 1499] }\n",
     kQuickWave, "7:9"},
    {"period_of_a_wave", kIbusInput,
     "protocol = \"sbus\"\ndevice = \"/dev/ttyB\"\nperiod = \"50ms\"\n",
     "[gpio.a]\nline = \"A\"\nrole = \"fresh\"\nperiod = 5", "14:10"},
    {"unknown_output_of_a_wave", kIbusInput, kSbusOutput,
     "[gpio.a]\nline = \"A\"\nrole = \"fresh\"\noutput = \"x\"", "13:10"},
    {"missing_line", kIbusInput, kSbusOutput, "[gpio.a]\nrole = \"link\"", "10:1"},
    {"negative_numbers_of_two_lines", kIbusInput, kSbusOutput,
     "[gpio.a]\nchip = \"gpiochip0\"\nline = -1\nrole = \"link\"\n"
     "[gpio.b]\nchip = \"gpiochip0\"\nline = -1\nrole = \"link\"",
     "12:8 16:8"},
    {"numbers_of_two_lines_without_a_chip", kIbusInput, kSbusOutput,
     "[gpio.a]\nline = 1\nrole = \"link\"\n[gpio.b]\nline = 1\nrole = \"link\"", "11:8 14:8"},
    {"missing_role_beside_a_key_of_some", kIbusInput, kSbusOutput,
     "[gpio.a]\nline = \"A\"\ndebounce = \"5ms\"", "10:1"},
    {"misspelt_role_beside_a_key_of_some", kIbusInput, kSbusOutput,
     "[gpio.a]\nline = \"A\"\nrole = \"fialsafe\"\ndebounce = \"5ms\"", "12:8"},
    {"number_for_the_name_of_a_button", kIbusInput, kSbusOutput,
     "[pipeline.main.channels]\n3 = { line = 5 }\n[gpio.lamp]\nline = \"B\"\nrole = \"link\"\n"
     "[gpio.a]\nline = \"A\"\nrole = \"button\"",
     "11:14"},
    {"unknown_name_of_a_button", kIbusInput, kSbusOutput,
     "[pipeline.main.channels]\n3 = { line = \"x\" }\n[gpio.lamp]\nline = \"B\"\nrole = \"link\"\n"
     "[gpio.bind]\nline = \"A\"\nrole = \"button\"",
     "11:14"},
    {"misspelt_role_of_a_button", kIbusInput, kSbusOutput,
     "[pipeline.main.channels]\n3 = { line = \"a\" }\n[gpio.a]\nline = \"A\"\nrole = \"buton\"",
     "14:8"},
    {"missing_source_of_a_switch", kIbusInput, kSbusOutput,
     "[pipeline.main.channels]\n1 = { above = 1700 }", "11:5"},
    {"line_of_a_rule_that_is_not_toml", kIbusInput, kSbusOutput,
     "[pipeline.main.failsafe.release_when]\nchannel = 3\nbelow 1050", "12:7"},
};
INSTANTIATE_TEST_SUITE_P(Lines, MistakeOfAJob, ::testing::ValuesIn(kLines), name_of);

constexpr Job kFailsafe[]{
    {"action_beside_presets", kIbusInput, kIbusOutput,
     "[pipeline.main.failsafe]\naction = \"presets\"\npreset = { 3 = 988 }", "11:10"},
    {"action_of_an_output_beside_its_presets", kIbusInput, kIbusOutput,
     "[pipeline.main.failsafe.output.servos]\naction = \"presets\"\npreset = { 3 = 988 }", "11:10"},
    {"protocol_of_an_output_with_presets", kIbusInput,
     "protocol = \"fm\"\ndevice = \"/dev/ttyB\"\n",
     "[pipeline.main.failsafe.output.servos]\npreset = { 3 = 988 }", "5:12"},
    {"setting_of_an_output_with_presets", kIbusInput,
     "protocol = \"ibus\"\ndevice = \"/dev/ttyB\"\nchannels = \"x\"\n",
     "[pipeline.main.failsafe]\npreset = { 3 = 988 }", "7:12"},
    {"setting_of_an_output_that_holds_for_long", kIbusInput,
     "protocol = \"ibus\"\ndevice = \"/dev/ttyB\"\nchannels = \"x\"\n",
     "[pipeline.main.failsafe]\nhold = \"301ms\"", "7:12"},
    {"setting_of_an_output_that_holds_for_ever", kIbusInput,
     "protocol = \"ibus\"\ndevice = \"/dev/ttyB\"\nchannels = \"x\"\n",
     "[pipeline.main.failsafe]\naction = \"hold\"", "7:12"},
    {"output_of_another_pipeline_beside_presets", kIbusInput, kIbusOutput,
     "[pipeline.b]\nfrom = \"receiver\"\nto = \"servos\"\n"
     "[pipeline.b.failsafe]\npreset = { 3 = 988 }",
     "12:6"},
};
INSTANTIATE_TEST_SUITE_P(Failsafe, MistakeOfAJob, ::testing::ValuesIn(kFailsafe), name_of);

constexpr Job kOthers[]{
    {"missing_devices_of_sensor_buses", kIbusInput, kSbusOutput,
     "[sensor_bus.a]\nrole = \"receiver\"\n[sensor_bus.b]\nrole = \"receiver\"", "10:1 12:1"},
    {"wrong_devices_of_sensor_buses", kIbusInput, kSbusOutput,
     "[sensor_bus.a]\ndevice = 3\nrole = \"receiver\"\n"
     "[sensor_bus.b]\ndevice = 3\nrole = \"receiver\"",
     "11:10 14:10"},
    {"missing_role_of_a_sensor_bus", kIbusInput, kSbusOutput,
     "[sensor_bus.a]\ndevice = \"/dev/ttyC\"", "10:1"},
    {"misspelt_role_of_a_sensor_bus", kIbusInput, kSbusOutput,
     "[sensor_bus.a]\ndevice = \"/dev/ttyC\"\nrole = \"sensr\"", "12:8"},
    {"missing_type_of_a_sensor", kIbusInput, kSbusOutput,
     "[sensor_bus.a]\ndevice = \"/dev/ttyC\"\nrole = \"sensor\"\n"
     "sensor = [{ value = \"machine.load\" }]",
     "13:11"},
    {"interface_of_a_dronecan_output", kIbusInput, "protocol = \"dronecan\"\ninterface = \"\"\n",
     "", "6:13"},
    {"node_id_of_a_dronecan_output", kIbusInput,
     "protocol = \"dronecan\"\ninterface = \"can1\"\nnode_id = 126\n", "", "7:11"},
    {"missing_interface_of_a_node", kIbusInput, kSbusOutput, "[dronecan.bus]", "10:1"},
    {"interface_of_a_node", kIbusInput, kSbusOutput, "[dronecan.bus]\ninterface = \"\"", "11:13"},
    {"node_id_of_a_node", kIbusInput, kSbusOutput,
     "[dronecan.bus]\ninterface = \"can1\"\nnode_id = 126", "12:11"},
    {"dynamic_of_a_node", kIbusInput, kSbusOutput,
     "[dronecan.bus]\ninterface = \"can1\"\ndynamic = 5", "12:11"},
    {"name_of_a_node", kIbusInput, kSbusOutput,
     "[dronecan.bus]\ninterface = \"can1\"\nnode_id = 7\nname = \"\"", "13:8"},
};
INSTANTIATE_TEST_SUITE_P(Others, MistakeOfAJob, ::testing::ValuesIn(kOthers), name_of);

/// Some name stands where only tables may stand, so the value may be of that table.
TEST(UnknownValue, MayBeOneOfATableWithoutAName) {
    const std::string sensor =
        main_job_with(10,
                      "[sensor_bus.t]\ndevice = \"/dev/ttyC\"\nrole = \"sensor\"\n"
                      "sensor = [{ type = \"external_voltage\", value = \"nothing.x\" }]");
    EXPECT_EQ(places(sensor), "13:48");
    for (const std::string table : {"values", "sensor_bus", "input", "output"}) {
        EXPECT_EQ(places(sensor + "[" + table + "]\nx = 5\n"), "15:1") << table;
    }
    EXPECT_EQ(places(sensor + "[values.nothing]]\nconstant = 5\n"), "14:17");
}

TEST(OutputOfALine, MayBeOneThatCouldNotBeRead) {
    const std::string line = "[gpio.a]\nline = \"A\"\nrole = \"link\"\noutput = \"servos\"\n";
    EXPECT_EQ(places(main_job_with(4, "[output.servos]]") + line), "4:16");
    EXPECT_EQ(places(main_job_with(4, "[output]") + line), "5:1 6:1");
}

TEST(UnknownOutput, LeavesOpenWhetherPresetsAreSent) {
    std::string text = main_job_with(9, "to = [\"servos\", \"x\"]") +
                       "[pipeline.main.failsafe]\npreset = { 3 = 988 }\n";
    text.replace(text.find("\"sbus\""), 6, "\"ibus\"");
    EXPECT_EQ(places(text), "9:17");
}

}  // namespace
}  // namespace tribus::test::told_alone_test
