#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

/// Several [gpio.NAME] beside each other, and several outputs of one.
namespace tribus::test::many_lines_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

std::string line(std::string_view name, std::string_view keys) {
    return "[gpio." + std::string(name) + "]\n" + std::string(keys) + "\n";
}

Lines mistakes_with(const std::string& lines) {
    return mistakes_in(main_job_with(10, lines));
}

TEST(ManyLines, MayHaveOneNameOnTwoChips) {
    EXPECT_EQ(mistakes_with(line("a", "chip = \"gpiochip0\"\nline = \"A\"\nrole = \"link\"") +
                            line("b", "chip = \"gpiochip1\"\nline = \"A\"\nrole = \"link\"")),
              Lines{});
}

TEST(ManyLines, AreComparedWithEachEarlierOne) {
    EXPECT_EQ(mistakes_with(line("a", "line = \"A\"\nrole = \"link\"") +
                            line("b", "line = \"B\"\nrole = \"link\"") +
                            line("c", "line = \"B\"\nrole = \"failsafe\"")),
              Lines{"t.toml:17:8: line \"B\" is already used by [gpio.b] in line 14 of the file; a "
                    "line has one role"});
}

TEST(ManyLines, AreToldOnceEachWhereTheyAreTheSame) {
    const std::string used =
        ": line \"A\" is already used by [gpio.a] in line 11 of the file; a line has one role";
    EXPECT_EQ(mistakes_with(line("a", "line = \"A\"\nrole = \"link\"") +
                            line("b", "line = \"A\"\nrole = \"link\"") +
                            line("c", "line = \"A\"\nrole = \"link\"")),
              (Lines{"t.toml:14:8" + used, "t.toml:17:8" + used}));
}

TEST(ManyLines, AreAllJudged) {
    EXPECT_EQ(mistakes_with(line("a", "line = \"A\"\nrole = \"link\"") +
                            line("b", "line = \"B\"\nrole = \"fresh\"\nperiod = \"20ms\""))
                  .size(),
              1U);
}

std::string numbered_lines(int count) {
    std::string lines;
    for (int i = 0; i < count; ++i) {
        const std::string number = std::to_string(i);
        lines += line("l" + number, "line = \"L" + number + "\"\nrole = \"link\"");
    }
    return lines;
}

TEST(ManyLines, MayBeAsManyAsAWordHasBits) {
    EXPECT_EQ(mistakes_with(numbered_lines(32)), Lines{});
}

TEST(ManyLines, AreNotComparedWhereTheyAreTooMany) {
    EXPECT_EQ(mistakes_with(numbered_lines(32) + line("b", "line = \"L0\"\nrole = \"link\"")),
              Lines{"t.toml:106:7: there are 33 lines; allowed: at most 32"});
}

constexpr std::string_view kLegs =
    "[output.legs]\nprotocol = \"pwm\"\nchip = \"pca9685-pwm\"\noutputs = { 1 = 0 }\n"
    "period = \"10ms\"\noutput_enable = \"GPIO22\"\n";

TEST(ManyLines, CountThoseThatOutputsName) {
    EXPECT_EQ(mistakes_in(main_job_with(9, "to = [\"servos\", \"legs\"]") + std::string(kLegs) +
                          numbered_lines(32)),
              Lines{"t.toml:15:17: there are 33 lines; allowed: at most 32"});
}

TEST(LineOfTheFirstOutput, IsItsWave) {
    const Configuration configuration =
        loaded(std::string(kLegs) + main_job_with(9, "to = [\"servos\", \"legs\"]"));
    ASSERT_EQ(configuration.lines.size(), 1U);
    EXPECT_EQ(configuration.lines[0].name, "legs.output_enable");
    EXPECT_EQ(configuration.lines[0].task.outputs, std::vector<std::size_t>{0});
}

constexpr std::string_view kTwoOutputs =
    "to = [\"servos\", \"b\"]\n[output.b]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyC\"\n";

TEST(LineWithoutAnOutput, IsThatOfAllOutputs) {
    const Configuration configuration = loaded(main_job_with(
        9, std::string(kTwoOutputs) + line("a", "line = \"A\"\nrole = \"failsafe\"")));
    ASSERT_EQ(configuration.lines.size(), 1U);
    EXPECT_EQ(configuration.lines[0].task.outputs, (std::vector<std::size_t>{0, 1}));
}

TEST(WaveOfSeveralOutputs, NamesTheFirstOfTheSlowest) {
    const auto found = mistakes_in(main_job_with(
        9,
        std::string(kTwoOutputs) + line("a", "line = \"A\"\nrole = \"fresh\"\nperiod = \"20ms\"")));
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NE(found[0].find("but output \"servos\" sends every \"14ms\""), std::string::npos)
        << found[0];
}

TEST(NumberOfALine, IsFromZeroTo31Bits) {
    const auto with = [](std::string_view number) {
        return mistakes_with(
            line("a", "chip = \"gpiochip0\"\nrole = \"link\"\nline = " + std::string(number)));
    };
    EXPECT_EQ(with("0"), Lines{});
    EXPECT_EQ(with("2147483647"), Lines{});
    EXPECT_EQ(with("2147483648"),
              Lines{"t.toml:13:8: \"line\" is 2147483648; allowed: the number of a line on its "
                    "chip, from 0, or a name, such as \"GPIO17\""});
}

}  // namespace
}  // namespace tribus::test::many_lines_test
