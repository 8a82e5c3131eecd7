#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "config/check/warnings.h"
#include "tests/unit/config/main_job.h"

/// Which parts of a configuration may use one device, interface or address.
namespace tribus::test::devices_test {
namespace {

using Lines = std::vector<std::string>;

Lines warnings_in(std::string_view text) {
    Lines lines;
    for (const Mistake& warning : warnings_about(loaded(text))) {
        lines.push_back(format_mistake(warning));
    }
    return lines;
}

constexpr std::string_view kReceiver =
    "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n";

/// Two outputs, "a" and "b", in the first line, with these keys.
std::string outputs_of_one_line(std::string_view a, std::string_view b) {
    return "output = { a = { " + std::string(a) + " }, b = { " + std::string(b) + " } }\n" +
           std::string(kReceiver) + "[pipeline.main]\nfrom = \"receiver\"\nto = [\"a\", \"b\"]\n";
}

TEST(PartsOfOneLine, AreToldInTheirOrder) {
    const std::string can = "protocol = \"can\", interface = \"can0\"";
    const std::string sbus = "protocol = \"sbus\", device = \"/dev/ttyB\"";
    for (const std::string& text :
         {outputs_of_one_line(can, can), outputs_of_one_line(sbus, sbus)}) {
        const Lines found = mistakes_in(text);
        ASSERT_EQ(found.size(), 1U);
        EXPECT_NE(found[0].find(" used by [output.a] in line 1"), std::string::npos) << found[0];
    }
    const Lines found =
        warnings_in(outputs_of_one_line(sbus, "protocol = \"sbus\", device = \"/dev/./ttyB\""));
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NE(found[0].find("\"/dev/./ttyB\" is the port that [output.a]"), std::string::npos)
        << found[0];
}

TEST(OutputBeforeAnInput, IsTheOneThatHadTheDeviceBefore) {
    EXPECT_EQ(mistakes_in("[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n" +
                          std::string(kReceiver) + std::string(kPipelineTable)),
              Lines{"t.toml:6:10: device \"/dev/ttyA\" is already used by [output.servos] in line "
                    "3 with 100000 baud 8E2, here with 115200 baud 8N1; an input and an output may "
                    "share a device if their line settings agree"});
    EXPECT_EQ(mistakes_in("[output.servos]\nprotocol = \"can\"\ninterface = \"can0\"\n"
                          "[input.receiver]\nprotocol = \"can\"\ninterface = \"can0\"\n" +
                          std::string(kPipelineTable)),
              Lines{"t.toml:6:13: on \"can0\" the id 0x300 of [input.receiver] is also used by "
                    "[output.servos] in line 3; allowed: ids that only one output sends and no "
                    "input of the same file receives"});
}

TEST(Address, ServesOneInput) {
    EXPECT_EQ(mistakes_in("[input.a]\nprotocol = \"sbus\"\naddress = \"127.0.0.1:5501\"\n"
                          "[input.b]\nprotocol = \"sbus\"\naddress = \"127.0.0.1:5501\"\n" +
                          std::string(kServosTable) +
                          "[pipeline.main]\nfrom = [\"a\", \"b\"]\nto = \"servos\"\n"),
              Lines{"t.toml:6:11: address \"127.0.0.1:5501\" is already used by [input.a] in line "
                    "3; one address serves one input or one output"});
}

constexpr std::string_view kHandset =
    "[output.servos]\nprotocol = \"crsf\"\nrole = \"handset\"\nbaud = 400000\n"
    "device = \"/dev/ttyB\"\n";

TEST(OutputThatReadsReplies, SharesItsDeviceWithNoInput) {
    const std::string job =
        "[input.receiver]\nprotocol = \"crsf\"\nbaud = 400000\ndevice = \"/dev/ttyB\"\n" +
        std::string(kHandset) + std::string(kPipelineTable);
    EXPECT_EQ(mistakes_in(job),
              Lines{"t.toml:9:10: device \"/dev/ttyB\" is already used by [input.receiver] in line "
                    "4; an output of this kind reads the replies on its device itself, so it "
                    "shares the device with [values.NAME] at most"});
}

TEST(OutputThatReadsReplies, SharesItsDeviceWithValues) {
    EXPECT_EQ(
        mistakes_in(std::string(kReceiver) + std::string(kHandset) + std::string(kPipelineTable) +
                    "[values.fc]\nprotocol = \"crsf-telemetry\"\ndevice = \"/dev/ttyB\"\n"
                    "baud = 400000\n"),
        Lines{});
}

TEST(SharedDevice, IsNoPortWithTwoNames) {
    EXPECT_EQ(warnings_in(std::string(kReceiverTable) +
                          "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n" +
                          std::string(kPipelineTable)),
              Lines{});
}

TEST(PathsOfTwoMedia, AreNoPortWithTwoNames) {
    EXPECT_EQ(warnings_in("[input.receiver]\nprotocol = \"gamepad\"\ndevice = \"/dev/./ttyB\"\n" +
                          std::string(kServosTable) + std::string(kPipelineTable)),
              Lines{});
}

std::string from_the_folder(std::string_view place, std::string_view device) {
    return "t.toml:" + std::string(place) + ": \"device\" is \"" + std::string(device) +
           "\", which counts from the folder in which the program is started; write the whole "
           "path, such as \"/dev/" +
           std::string(device) + "\"";
}

TEST(DeviceWithoutALeadingSlash, IsDoubtfulOfEachPart) {
    EXPECT_EQ(warnings_in(main_job_with(6, "device = \"ttyB\"") +
                          "[sensor_bus.probes]\ndevice = \"ttyC\"\nrole = \"receiver\"\n"
                          "[values.fc]\nprotocol = \"crsf-telemetry\"\ndevice = \"ttyD\"\n"),
              (Lines{from_the_folder("6:10", "ttyB"), from_the_folder("11:10", "ttyC"),
                     from_the_folder("15:10", "ttyD")}));
}

constexpr std::string_view kSender =
    "[output.servos]\nprotocol = \"crsf\"\naddress = \"127.0.0.1:5502\"\n";
constexpr std::string_view kHearer =
    "[values.fc]\nprotocol = \"crsf-telemetry\"\naddress = \"0.0.0.0:5502\"\npublic = true\n";

std::string hears(std::string_view place, int line) {
    return "t.toml:" + std::string(place) +
           ": [values.fc] hears at \"0.0.0.0:5502\" what [output.servos] in line " +
           std::to_string(line) +
           " sends to \"127.0.0.1:5502\", so this program would follow itself; give them different "
           "ports";
}

TEST(ValuesThatHearAnOwnOutput, AreDoubtfulInAnyOrder) {
    const std::string rest = std::string(kReceiver) + std::string(kPipelineTable);
    EXPECT_EQ(warnings_in(std::string(kSender) + std::string(kHearer) + rest),
              Lines{hears("6:11", 3)});
    EXPECT_EQ(warnings_in(std::string(kHearer) + std::string(kSender) + rest),
              Lines{hears("3:11", 7)});
}

TEST(TwoInputsOrTwoOutputs, DoNotHearEachOther) {
    const std::string one = "protocol = \"sbus\"\naddress = \"127.0.0.1:5501\"\n";
    const std::string other = "protocol = \"sbus\"\naddress = \"0.0.0.0:5501\"\npublic = true\n";
    EXPECT_EQ(warnings_in("[input.a]\n" + one + "[input.b]\n" + other + std::string(kServosTable) +
                          "[pipeline.main]\nfrom = [\"a\", \"b\"]\nto = \"servos\"\n"),
              Lines{});
    EXPECT_EQ(warnings_in(std::string(kReceiver) + "[output.a]\n" + one + "[output.b]\n" + other +
                          "[pipeline.main]\nfrom = \"receiver\"\nto = [\"a\", \"b\"]\n"),
              Lines{});
}

TEST(TwoTables, MayReadOneMessage) {
    const std::string keys =
        "interface = \"can0\"\ndronecan = \"uavcan.equipment.power.BatteryInfo\"\n";
    EXPECT_EQ(warnings_in(main_job_with(10, "[values.a]\n" + keys + "[values.b]\n" + keys)),
              Lines{});
}

TEST(TimeoutAsShortAsThePeriod, NamesTheFirstOfTheSlowestOutputs) {
    EXPECT_EQ(mistakes_in(std::string(kReceiver) +
                          "[output.a]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                          "period = \"100ms\"\n"
                          "[output.b]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyC\"\n"
                          "period = \"100ms\"\n"
                          "[pipeline.main]\nfrom = \"receiver\"\nto = [\"a\", \"b\"]\n"),
              Lines{"t.toml:7:10: the timeout of input \"receiver\" is \"100ms\", but output \"a\" "
                    "sends every \"100ms\": each frame would be judged too old; allowed: a timeout "
                    "longer than the period"});
}

TEST(OutputOfValuesOnly, MayBeSlowerThanTheTimeout) {
    EXPECT_EQ(mistakes_in(main_job_with(9, "to = [\"servos\", \"fc\"]") +
                          "[output.fc]\nprotocol = \"crsf-telemetry\"\ndevice = \"/dev/ttyC\"\n"
                          "period = \"1s\"\nbattery = { voltage = \"cells\" }\n"
                          "[values.cells]\nconstant = 6\nunit = \"V\"\n"),
              Lines{});
}

}  // namespace
}  // namespace tribus::test::devices_test
