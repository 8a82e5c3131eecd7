#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "tests/unit/config/main_job.h"

/// Each id on one CAN interface has exactly one sender.
namespace tribus::test::can_ids_test {
namespace {

using Lines = std::vector<std::string>;

/// Returns outputs named "o1", "o2" and so on, one for each set of lines, and an i.Bus input.
std::string outputs(const std::vector<std::string>& lines) {
    std::string text = "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n";
    std::string names;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        text += fmt::format("[output.o{}]\nprotocol = \"can\"\n{}\n", i + 1, lines[i]);
        names += fmt::format("\"o{}\",", i + 1);
    }
    return text + fmt::format("[pipeline.main]\nfrom = \"receiver\"\nto = [{}]\n", names);
}

/// Returns an input and an output on one interface, and the serial ports that they need.
std::string input_and_output(std::string_view input, std::string_view output) {
    return fmt::format(R"([input.cockpit]
protocol = "can"
interface = "can0"
{}
[output.bus]
protocol = "can"
interface = "can0"
{}
[pipeline.main]
from = "cockpit"
to = "bus"
)",
                       input, output);
}

TEST(CanIds, TwoOutputsOfOneInterfaceMayNotShareAny) {
    EXPECT_EQ(
        mistakes_in(outputs({"interface = \"can0\"", "interface = \"can0\"\nid = 0x304"})),
        Lines{R"(t.toml:9:13: on "can0" the id 0x304 of [output.o2] is also used by [output.o1] )"
              R"(in line 6; allowed: ids that only one output sends and no input of the same )"
              R"(file receives)"});
}

TEST(CanIds, OnDifferentInterfacesAreDifferentIds) {
    EXPECT_EQ(mistakes_in(outputs({"interface = \"can0\"", "interface = \"can1\""})), Lines{});
}

TEST(CanIds, ThatLieSideBySideAreFine) {
    EXPECT_EQ(mistakes_in(outputs({"interface = \"can0\"", "interface = \"can0\"\nid = 0x305"})),
              Lines{});
}

TEST(CanIds, Of29BitsAreOthersThanThoseOf11) {
    EXPECT_EQ(
        mistakes_in(outputs({"interface = \"can0\"", "interface = \"can0\"\nextended = true"})),
        Lines{});
}

TEST(CanIds, ForClassicAndFdFramesFitUnderOneBaseId) {
    EXPECT_EQ(mistakes_in(outputs({"interface = \"can0\"", "interface = \"can0\"\nfd = true"})),
              Lines{});
}

TEST(CanIds, ForTheFifthFrameAreFreeWith16Channels) {
    EXPECT_EQ(mistakes_in(outputs(
                  {"interface = \"can0\"\nchannels = 16", "interface = \"can0\"\nid = 0x304"})),
              Lines{});
}

TEST(CanIds, ThatAnOutputSendsMayNoInputOfTheFileListenTo) {
    EXPECT_EQ(
        mistakes_in(
            input_and_output("extended = true\nid = 0x10000", "extended = true\nid = 0x10002")),
        Lines{R"(t.toml:8:13: on "can0" the id 0x10002 (29 bits) of [output.bus] is also used )"
              R"(by [input.cockpit] in line 3; allowed: ids that only one output sends and no )"
              R"(input of the same file receives)"});
}

TEST(CanIds, AreFineForAnInputAndAnOutputSideBySide) {
    EXPECT_EQ(mistakes_in(input_and_output("", "id = 0x400")), Lines{});
}

TEST(CanIds, MayBeReadByTwoInputs) {
    EXPECT_EQ(mistakes_in(R"([input.a]
protocol = "can"
interface = "can0"
[input.b]
protocol = "can"
interface = "can0"
timeout = "200ms"
[output.servos]
protocol = "sbus"
device = "/dev/ttyB"
[pipeline.main]
from = ["a", "b"]
to = "servos"
)"),
              Lines{});
}

TEST(CanIds, EachPairThatSharesSomeIsAMistakeOfItsOwnInTheOrderOfTheFile) {
    const Lines three = mistakes_in(
        outputs({"interface = \"can0\"", "interface = \"can0\"", "interface = \"can0\""}));
    ASSERT_EQ(three.size(), 3U);
    EXPECT_TRUE(three[0].starts_with("t.toml:9:13: ")) << three[0];
    EXPECT_TRUE(three[1].starts_with("t.toml:12:13: ")) << three[1];
    EXPECT_TRUE(three[2].starts_with("t.toml:12:13: ")) << three[2];
}

TEST(CanIds, AreNotComparedWhereTheyAreWrongThemselves) {
    const Lines found = mistakes_in(
        outputs({"interface = \"can0\"\nid = 0x7FB", "interface = \"can0\"\nid = 0x7FB"}));
    ASSERT_EQ(found.size(), 2U);
    for (const std::string& line : found) {
        EXPECT_NE(line.find("too high"), std::string::npos) << line;
    }
}

Lines outputs_of_one_interface(int count) {
    Lines lines;
    for (int i = 0; i < count; ++i) {
        lines.push_back(fmt::format("interface = \"can0\"\nid = {}", 0x100 + 0x10 * i));
    }
    return lines;
}

TEST(CanIds, OneInterfaceServes16Outputs) {
    EXPECT_EQ(mistakes_in(outputs(outputs_of_one_interface(16))), Lines{});
}

TEST(CanIds, TheSeventeenthOutputOfOneInterfaceIsAMistakeOnce) {
    EXPECT_EQ(
        mistakes_in(outputs(outputs_of_one_interface(18))),
        Lines{R"(t.toml:70:13: "can0" has more outputs than an interface can serve; allowed: 16 )"
              R"(outputs on one interface)"});
}

TEST(CanIds, OutputsOfOtherInterfacesDoNotCount) {
    Lines lines = outputs_of_one_interface(16);
    lines.emplace_back("interface = \"can1\"");
    EXPECT_EQ(mistakes_in(outputs(lines)), Lines{});
}

}  // namespace
}  // namespace tribus::test::can_ids_test
