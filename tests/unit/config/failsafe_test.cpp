#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "config/load.h"
#include "tests/unit/config/main_job.h"

namespace tribus::test::failsafe_test {
namespace {

using std::chrono::milliseconds;
using Lines = std::vector<std::string>;

/// One pipeline to an SBUS output, which can mark failsafe, and to an i.Bus output, which cannot.
constexpr std::string_view kTwoOutputs = R"([input.receiver]
protocol = "ibus"
device = "/dev/ttyA"
[output.servos]
protocol = "sbus"
device = "/dev/ttyB"
[output.autopilot]
protocol = "ibus"
device = "/dev/ttyC"
[pipeline.main]
from = "receiver"
to = ["servos", "autopilot"]
[pipeline.main.failsafe]
)";
/// The first line after it.
constexpr std::string_view kLine14 = "t.toml:14:";

std::string with(std::string_view failsafe) {
    return std::string(kTwoOutputs) + std::string(failsafe);
}

std::vector<FailsafeSettings> loaded(std::string_view failsafe) {
    const auto configuration = load_configuration(with(failsafe), "t.toml");
    if (!configuration) {
        ADD_FAILURE() << format_mistake(configuration.error().front());
        return std::vector<FailsafeSettings>(2);
    }
    return configuration->pipelines[0].failsafe;
}

TEST(Failsafe, DefaultsToPresetWhereTheProtocolCanSaySoElseToSilence) {
    const auto failsafe = loaded("");
    EXPECT_EQ(failsafe[0].action, FailsafeAction::preset);
    EXPECT_EQ(failsafe[1].action, FailsafeAction::silence);
}

TEST(Failsafe, TheDefaultPresetIsThrottleLowAndTheRestCentred) {
    const auto presets = loaded("")[0].presets;
    for (std::size_t i = 0; i < presets.size(); ++i) {
        EXPECT_EQ(presets[i], Pulse::from_microseconds(i == 2 ? 988 : 1500)) << i;
    }
}

TEST(Failsafe, AGivenPresetReplacesTheDefaultWholly) {
    const auto presets = loaded("preset = { 1 = 1200 }")[0].presets;
    EXPECT_EQ(presets[0], Pulse::from_microseconds(1200));
    EXPECT_EQ(presets[2], Pulse::from_microseconds(1500));
}

TEST(Failsafe, OtherIsForAllChannelsThatThePresetDoesNotName) {
    const auto presets = loaded("preset = { 18 = 2000, other = 1000.5 }")[0].presets;
    EXPECT_EQ(presets[17], Pulse::from_microseconds(2000));
    EXPECT_EQ(presets[0], Pulse::from_eighths(8004));
    EXPECT_EQ(presets[16], Pulse::from_eighths(8004));
}

TEST(Failsafe, AnOutputInheritsWhatItDoesNotSayItself) {
    const auto failsafe = loaded(R"(hold = "200ms"
action = "silence"
recover = "1s"
[pipeline.main.failsafe.output.autopilot]
action = "preset"
hold = "0ms"
preset = { other = 1100 }
)");
    EXPECT_EQ(failsafe[0].action, FailsafeAction::silence);
    EXPECT_EQ(failsafe[0].hold, milliseconds(200));
    EXPECT_EQ(failsafe[1].action, FailsafeAction::preset);
    EXPECT_EQ(failsafe[1].hold, milliseconds(0));
    EXPECT_EQ(failsafe[1].recover, milliseconds(1000));
    EXPECT_EQ(failsafe[1].presets[4], Pulse::from_microseconds(1100));
}

TEST(Failsafe, HoldingOldValuesUnmarkedForEverIsRefused) {
    EXPECT_EQ(mistakes_in(with("action = \"hold\"\n")),
              Lines{std::string(kLine14) +
                    "10: \"action\" is \"hold\", but \"ibus\" of output \"autopilot\" cannot say "
                    "failsafe: it would repeat old values unmarked; allowed there: \"preset\", "
                    "\"silence\""});
}

TEST(Failsafe, HoldIsAllowedIfTheOutputThatCannotSaySoDiffers) {
    const auto failsafe = loaded(R"(action = "hold"
[pipeline.main.failsafe.output.autopilot]
action = "silence"
)");
    EXPECT_EQ(failsafe[0].action, FailsafeAction::hold);
    EXPECT_EQ(failsafe[1].action, FailsafeAction::silence);
}

TEST(Failsafe, APresetThatTheDefaultActionOfItsOutputIgnoresIsAMistake) {
    EXPECT_EQ(
        mistakes_in(with("[pipeline.main.failsafe.output.autopilot]\npreset = { 3 = 988 }")),
        Lines{"t.toml:15:1: \"preset\" is not sent in failsafe: without \"action\", an output "
              "whose protocol cannot say failsafe goes silent; add action = \"preset\", or action "
              "= \"silence\" if \"preset\" is only for channels that the input lacks"});
}

TEST(Failsafe, APresetBesideAnotherActionIsKeptForLater) {
    EXPECT_EQ(mistakes_in(with("action = \"silence\"\npreset = { 3 = 988 }")), Lines{});
}

/// One output that cannot say failsafe. The first line of the text is line 11.
Lines mistakes_of_silent_output(std::string_view failsafe) {
    return mistakes_in(main_job_with(5, "protocol = \"ibus\"") + "[pipeline.main.failsafe]\n" +
                       std::string(failsafe));
}

constexpr std::string_view kNotSent =
    "\"preset\" is not sent in failsafe: without \"action\", an output whose protocol cannot say "
    "failsafe goes silent; add action = \"preset\", or action = \"silence\" if \"preset\" is only "
    "for channels that the input lacks";

TEST(Failsafe, APresetThatTheDefaultActionOfAllOutputsIgnoresIsAMistake) {
    EXPECT_EQ(mistakes_of_silent_output("preset = { 3 = 988 }"),
              Lines{"t.toml:11:1: " + std::string(kNotSent)});
    EXPECT_EQ(mistakes_in(with("preset = { 3 = 988 }")), Lines{}) << "SBUS sends it";
}

TEST(Failsafe, APresetThatTheOnlyOutputReplacesIsAMistakeWithoutAnAction) {
    const std::string own = "[pipeline.main.failsafe.output.servos]\npreset = { 3 = 990 }\n";
    EXPECT_EQ(
        mistakes_of_silent_output("preset = { 3 = 988 }\n" + own),
        (Lines{"t.toml:11:1: " + std::string(kNotSent), "t.toml:13:1: " + std::string(kNotSent)}));
    EXPECT_EQ(
        mistakes_in(main_job_with(10, "[pipeline.main.failsafe]\npreset = { 3 = 988 }\n" + own)),
        Lines{"t.toml:11:1: " + std::string(kNotSent)});
    EXPECT_EQ(mistakes_of_silent_output("action = \"silence\"\npreset = { 3 = 988 }\n" + own),
              Lines{});
}

TEST(Failsafe, APresetOfAnOutputIsSentByItsOwnOrTheCommonAction) {
    EXPECT_EQ(mistakes_of_silent_output("[pipeline.main.failsafe.output.servos]\n"
                                        "action = \"preset\"\npreset = { 3 = 988 }"),
              Lines{});
    EXPECT_EQ(mistakes_of_silent_output("action = \"preset\"\n"
                                        "[pipeline.main.failsafe.output.servos]\n"
                                        "preset = { 3 = 988 }"),
              Lines{});
}

TEST(Failsafe, ControlBeginsAfterTheTimeThatItTakesToRecover) {
    EXPECT_EQ(loaded("recover = \"2s\"")[0].power_on, milliseconds(2000));
    EXPECT_EQ(loaded("recover = \"2s\"\npower_on = \"1s\"")[0].power_on, milliseconds(1000));
}

}  // namespace
}  // namespace tribus::test::failsafe_test
