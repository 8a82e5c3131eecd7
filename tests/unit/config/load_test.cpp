#include "config/load.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include "tests/support/temporary_folder.h"
#include "tests/unit/config/main_job.h"

namespace tribus::test::load_test {
namespace {

using std::chrono::milliseconds;
using Lines = std::vector<std::string>;

Configuration loaded(std::string_view text) {
    const auto configuration = load_configuration(text, "t.toml");
    if (!configuration) {
        ADD_FAILURE() << format_mistake(configuration.error().front());
        return {};
    }
    return *configuration;
}

Configuration main_job(std::size_t line = 0, std::string_view replacement = {}) {
    return loaded(main_job_with(line, replacement));
}

TEST(Load, TenMistakesGiveTenPreciseLines) {
    const std::filesystem::path path =
        std::filesystem::path(TRIBUS_SOURCE_DIR) / "tests/unit/config/ten_mistakes.toml";
    const auto configuration = load_configuration_file(path);
    ASSERT_FALSE(configuration);
    Lines found;
    for (const Mistake& mistake : configuration.error()) {
        EXPECT_EQ(mistake.file, path.string());
        const std::string line = format_mistake({"f", mistake.where, mistake.text});
        found.push_back(line.substr(0, line.find(';')));
    }
    const Lines expected{
        R"(f:2:12: "priority" is 100)",
        R"(f:5:12: "protocol" is "ibsu")",
        R"(f:6:12: /dev/ttyAMA5 is not a valid value)",
        R"(f:7:12: "timeout" is 100)",
        R"(f:11:1: unknown key "devcie" in [output.servos])",
        R"(f:12:12: "period" is "5ms", shorter than readers of "sbus" can follow)",
        R"(f:15:8: no input is named "reciever")",
        R"(f:19:36: "min" is 1900 and "max" is 1100, so no value would be allowed)",
        R"(f:20:1: "19" is not an output channel)",
        R"(f:23:10: "action" is "freeze")",
    };
    EXPECT_EQ(expected.size(), 10U);
    EXPECT_EQ(found, expected);
}

TEST(Load, FillsInTheDefaultsOfTheNineLines) {
    const Configuration configuration = main_job();
    EXPECT_EQ(configuration.file, "t.toml");
    EXPECT_EQ(configuration.runtime.realtime, Realtime::automatic);
    EXPECT_EQ(configuration.runtime.priority, 80);
    EXPECT_EQ(configuration.runtime.cpu, std::nullopt);
    ASSERT_EQ(configuration.inputs.size(), 1U);
    EXPECT_EQ(configuration.inputs[0].supervision.timeout, milliseconds(100));
    EXPECT_TRUE(configuration.inputs[0].supervision.failsafe_when.empty());
    ASSERT_EQ(configuration.outputs.size(), 1U);
    EXPECT_EQ(configuration.outputs[0].schedule.kind, ScheduleKind::follow);
    EXPECT_EQ(configuration.outputs[0].schedule.phase, Phase::free);
    EXPECT_EQ(configuration.outputs[0].schedule.period,
              configuration.outputs[0].protocol->default_period);
    EXPECT_FALSE(configuration.outputs[0].force);
    ASSERT_EQ(configuration.pipelines.size(), 1U);
    EXPECT_EQ(configuration.pipelines[0].selection.inputs, std::vector<std::size_t>{0});
    EXPECT_EQ(configuration.pipelines[0].outputs, std::vector<std::size_t>{0});
    EXPECT_TRUE(configuration.pipelines[0].channels.empty());
    ASSERT_EQ(configuration.pipelines[0].failsafe.size(), 1U);
    EXPECT_EQ(configuration.pipelines[0].failsafe[0].hold, milliseconds(300));
    EXPECT_EQ(configuration.pipelines[0].failsafe[0].recover, milliseconds(500));
}

TEST(Load, TakesLineSettingsFromTheProtocolAndTheBaudFromTheFile) {
    const Configuration configuration = main_job(6, "device = \"/dev/ttyB\"\nbaud = 200000");
    const PortConfig& port = configuration.outputs[0].port;
    EXPECT_EQ(port.device, "/dev/ttyB");
    EXPECT_EQ(port.line.baud, 200000U);
    EXPECT_EQ(port.line.parity, Parity::even);
    EXPECT_EQ(port.line.stop_bits, 2U);
    EXPECT_EQ(port.where.line, 6U);
    EXPECT_EQ(port.where.column, 10U);
}

TEST(Load, HandsTheProtocolItsOwnKeysWithTheirDefaults) {
    const Configuration configuration =
        main_job(6, "device = \"/dev/ttyB\"\nscale = { raw = [0, 2000], us = [1000, 2000.5] }");
    const auto* scale = configuration.outputs[0].settings.find_as<TwoPoints>("scale");
    ASSERT_NE(scale, nullptr);
    EXPECT_EQ(*scale, (TwoPoints{{0, 2000}, {1000, 2000.5}}));
    const auto* slots = configuration.inputs[0].settings.find_as<std::string>("slots");
    ASSERT_NE(slots, nullptr);
    EXPECT_EQ(*slots, "nibbles");
    EXPECT_EQ(configuration.inputs[0].settings.find("device"), nullptr);
}

TEST(Load, ReadsValueRulesWithChannelsCountedFromZero) {
    const Configuration configuration =
        main_job(3,
                 "device = \"/dev/ttyA\"\nfailsafe_when = [{ channel = 3, below = 950.5 }, "
                 "{ channel = 18, below = 900, above = 2100 }]");
    const auto& rules = configuration.inputs[0].supervision.failsafe_when;
    ASSERT_EQ(rules.size(), 2U);
    EXPECT_EQ(rules[0].channel, 2U);
    EXPECT_EQ(rules[0].below, Pulse::from_eighths(7604));
    EXPECT_EQ(rules[0].above, std::nullopt);
    EXPECT_EQ(rules[1].channel, 17U);
    EXPECT_EQ(rules[1].above, Pulse::from_microseconds(2100));
}

TEST(Load, ReadsEveryKindOfChannelEntry) {
    const Configuration configuration = main_job(10, R"([pipeline.main.channels]
17 = { from = 9, above = 1700, below = 1200 }
1 = 2
2 = { from = 1, reverse = true, trim = -12, min = 1100, max = 1900, slew = "2000us/s" }
3 = { mix = { 1 = 0.5, 2 = -1 }, expo = 0.3, deadband = 4 }
16 = { fixed = 1500.125 })");
    const auto& rules = configuration.pipelines[0].channels;
    ASSERT_EQ(rules.size(), 5U);
    EXPECT_EQ(rules[0].output, 0U);
    EXPECT_EQ(std::get<FromChannel>(rules[0].source).channel, 1U);
    EXPECT_TRUE(rules[1].reverse);
    EXPECT_EQ(rules[1].trim, Pulse::from_microseconds(-12));
    EXPECT_EQ(rules[1].min, Pulse::from_microseconds(1100));
    EXPECT_EQ(rules[1].max, Pulse::from_microseconds(1900));
    EXPECT_EQ(rules[1].slew_us_per_second, 2000.0);
    const Mix& mix = std::get<Mix>(rules[2].source);
    ASSERT_EQ(mix.terms.size(), 2U);
    EXPECT_EQ(mix.terms[1].channel, 1U);
    EXPECT_EQ(mix.terms[1].weight, -1.0);
    EXPECT_EQ(rules[2].expo, 0.3);
    EXPECT_EQ(rules[2].deadband, Pulse::from_microseconds(4));
    EXPECT_EQ(std::get<Fixed>(rules[3].source).pulse, Pulse::from_eighths(12001));
    const Switch& limits = std::get<Switch>(rules[4].source);
    EXPECT_EQ(limits.channel, 8U);
    EXPECT_EQ(limits.above, Pulse::from_microseconds(1700));
    EXPECT_EQ(limits.below, Pulse::from_microseconds(1200));
}

TEST(Load, ReadsTheRuntime) {
    const Configuration configuration =
        main_job(10, "[runtime]\nrealtime = \"require\"\npriority = 1\ncpu = 3");
    EXPECT_EQ(configuration.runtime.realtime, Realtime::require);
    EXPECT_EQ(configuration.runtime.priority, 1);
    EXPECT_EQ(configuration.runtime.cpu, 3);
}

TEST(Load, KeepsTheOrderOfTheFileNotOfTheAlphabet) {
    const Configuration both = loaded(R"([input.zulu]
protocol = "ibus"
device = "/dev/ttyA"
[input.alpha]
protocol = "sbus"
device = "/dev/ttyC"
[output.servos]
protocol = "sbus"
device = "/dev/ttyB"
[pipeline.main]
from = ["alpha", "zulu"]
to = "servos")");
    ASSERT_EQ(both.inputs.size(), 2U);
    EXPECT_EQ(both.inputs[0].name, "zulu");
    EXPECT_EQ(both.pipelines[0].selection.inputs, (std::vector<std::size_t>{1, 0}));
}

TEST(Load, LetsAnInputAndAnOutputWithTheSameLineShareADevice) {
    EXPECT_EQ(mistakes_in(R"([input.receiver]
protocol = "sbus"
device = "/dev/ttyA"
[output.servos]
protocol = "sbus"
device = "/dev/ttyA"
[pipeline.main]
from = "receiver"
to = "servos")"),
              Lines{});
}

TEST(Load, AllowsAShortPeriodByForceDownToTheWireTime) {
    // 26 bytes of 12 bits at 100000 baud are 3.12 ms.
    const Configuration configuration =
        main_job(6, "device = \"/dev/ttyB\"\nforce = true\nperiod = \"3120us\"");
    EXPECT_EQ(configuration.outputs[0].schedule.period, std::chrono::microseconds(3120));
}

TEST(Load, SaysWhatIsWrongWithAFileThatIsNotThere) {
    const auto configuration = load_configuration_file("no-such-folder/no-such-file.toml");
    ASSERT_FALSE(configuration);
    ASSERT_EQ(configuration.error().size(), 1U);
    EXPECT_EQ(format_mistake(configuration.error()[0]),
              "no-such-folder/no-such-file.toml: cannot be read: No such file or directory; give "
              "the path of a configuration file");
}

/// The disk may not be mounted yet. A mistake remains one however often the file is read.
TEST(Load, MayGoWellAnotherTimeForAFileThatCannotBeRead) {
    const auto missing = load_configuration_file("no-such-folder/no-such-file.toml");
    ASSERT_FALSE(missing);
    EXPECT_TRUE(may_be_temporary(missing.error()));
}

TEST(Load, MayGoWellAnotherTimeForAFileThatNamesOneThatCannotBeRead) {
    const std::string text =
        "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
        "[output.bus]\nprotocol = \"dbc\"\ninterface = \"can0\"\ndbc = \"none.dbc\"\n"
        "signals.Sticks.First = { channel = 1 }\n"
        "[pipeline.main]\nfrom = \"receiver\"\nto = \"bus\"\n";
    const auto missing = load_configuration(text, "t.toml");
    ASSERT_FALSE(missing);
    EXPECT_TRUE(may_be_temporary(missing.error())) << format_mistake(missing.error().front());
    const auto mistaken = load_configuration(text + "colour = \"red\"\n", "t.toml");
    ASSERT_FALSE(mistaken);
    EXPECT_FALSE(may_be_temporary(mistaken.error()));
}

TEST(Load, SaysThatAFolderIsNoFile) {
    const auto configuration = load_configuration_file(TRIBUS_SOURCE_DIR);
    ASSERT_FALSE(configuration);
    EXPECT_NE(configuration.error()[0].text.find("it is a folder"), std::string::npos);
}

TEST(Load, AcceptsAThousandPipelinesWithEighteenRulesEach) {
    std::string text;
    for (int i = 0; i < 1000; ++i) {
        text += fmt::format(
            "[input.in{0}]\nprotocol = \"ibus\"\ndevice = \"/dev/in{0}\"\n"
            "[output.out{0}]\nprotocol = \"sbus\"\ndevice = \"/dev/out{0}\"\n"
            "[pipeline.p{0}]\nfrom = [\"in{0}\"]\nto = [\"out{0}\"]\n[pipeline.p{0}.channels]\n",
            i);
        for (int channel = 1; channel <= 18; ++channel) {
            text += fmt::format("{} = {{ from = {}, trim = 5, min = 1000, max = 2000 }}\n", channel,
                                19 - channel);
        }
    }
    const auto configuration = load_configuration(text, "t.toml");
    ASSERT_TRUE(configuration) << format_mistake(configuration.error().front());
    EXPECT_EQ(configuration->pipelines.size(), 1000U);
}

TEST(Load, RefusesAFileOfAbsurdLength) {
    const auto lines = mistakes_in(std::string(5'000'000, '#'));
    EXPECT_EQ(lines, Lines{"t.toml:1:1: the file is too long; allowed: at most 4194304 bytes"});
}

TEST(Load, ReadsAFileOfTheLargestSizeToItsEnd) {
    const TemporaryFolder folder;
    const std::string start = "#";
    const std::string end = "\n" + main_job_with(9, "to = \"servos\" ]");
    const std::string filled =
        start + std::string(4'194'304 - start.size() - end.size(), '#') + end;
    const auto refused = load_configuration_file(folder.write("largest.toml", filled));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().front().where.line, 10U) << refused.error().front().text;
    const auto longer = load_configuration_file(folder.write("longer.toml", "#" + filled));
    ASSERT_FALSE(longer);
    EXPECT_EQ(longer.error().front().text, "the file is too long; allowed: at most 4194304 bytes");
}

TEST(Load, JudgesTheDevicesOfAFile) {
    const auto refused =
        load_configuration_draft(main_job_with(3, "device = \"/dev/null\""), "t.toml");
    ASSERT_FALSE(refused);
    ASSERT_EQ(refused.error().size(), 1U);
    EXPECT_EQ(
        format_mistake(refused.error().front()),
        "t.toml:3:10: \"device\" is \"/dev/null\": this is not a serial device; give a serial "
        "device, such as /dev/ttyUSB0");
}

TEST(Load, TakesTheLeastSpacingFromTheProtocol) {
    EXPECT_EQ(main_job().outputs.at(0).schedule.least_spacing, milliseconds(6)) << "that of SBUS";
}

}  // namespace
}  // namespace tribus::test::load_test
