#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

namespace tribus::test::mistakes_in_failsafe_test {
namespace {

class MistakeInFailsafe : public ::testing::TestWithParam<Spoilt> {};

TEST_P(MistakeInFailsafe, IsReportedWithItsPlaceAndWhatIsAllowed) {
    const Spoilt& spoilt = GetParam();
    const auto mistakes = mistakes_in(main_job_with(spoilt.line, spoilt.replacement));
    EXPECT_EQ(mistakes, std::vector<std::string>{std::string(spoilt.expected)});
}

constexpr Spoilt kMistakes[]{
    {"failsafe_that_is_no_table", 10, R"(failsafe = "hold")",
     R"(t.toml:10:12: [pipeline.main.failsafe] is "hold"; allowed: a table)"},
    {"action_misspelt", 10,
     R"([pipeline.main.failsafe]
action = "presets")",
     R"(t.toml:11:10: "action" is "presets"; did you mean "preset"? Allowed: "preset", )"
     R"("hold", "silence")"},
    {"hold_too_long", 10,
     R"([pipeline.main.failsafe]
hold = "10001ms")",
     R"(t.toml:11:8: "hold" is "10001ms"; allowed: a duration from "0s" to "10s", text )"
     R"(with a unit (us, ms, s) such as "300ms")"},
    {"recover_too_long", 10,
     R"([pipeline.main.failsafe]
recover = "61s")",
     R"(t.toml:11:11: "recover" is "61s"; allowed: a duration from "0s" to "60s", text )"
     R"(with a unit (us, ms, s) such as "500ms")"},
    {"preset_that_is_no_table", 10,
     R"([pipeline.main.failsafe]
preset = 1500)",
     R"(t.toml:11:10: "preset" is 1500; allowed: a table of pulses by channel number, )"
     R"(such as { 3 = 988, other = 1500 })"},
    {"preset_with_a_channel_out_of_range", 10,
     R"([pipeline.main.failsafe]
preset = { 0 = 1500 })",
     R"(t.toml:11:12: "0" in "preset" is not a channel; allowed: channel numbers from 1 )"
     R"(to 18, and "other")"},
    {"preset_with_other_misspelt", 10,
     R"([pipeline.main.failsafe]
preset = { 3 = 988, othr = 1500 })",
     R"(t.toml:11:21: "othr" in "preset" is not a channel; did you mean "other"? )"
     R"(Allowed: channel numbers from 1 to 18, and "other")"},
    {"preset_with_a_pulse_out_of_range", 10,
     R"([pipeline.main.failsafe]
preset = { 3 = 499 })",
     R"(t.toml:11:16: "preset.3" is 499; allowed: microseconds from 500 to 2500)"},
    {"preset_with_other_out_of_range", 10,
     R"([pipeline.main.failsafe]
preset = { other = 2501 })",
     R"(t.toml:11:20: "preset.other" is 2501; allowed: microseconds from 500 to 2500)"},
    {"unknown_key", 10,
     R"([pipeline.main.failsafe]
timeout = "100ms")",
     R"(t.toml:11:1: unknown key "timeout" in [pipeline.main.failsafe]; it belongs in )"
     R"([input.NAME]; allowed: "hold", "action", "preset", "slew", "recover", )"
     R"("power_on", "release_when", "output")"},
    {"output_that_is_no_table", 10,
     R"([pipeline.main.failsafe]
output = "servos")",
     R"(t.toml:11:10: [pipeline.main.failsafe.output] is "servos"; allowed: a table for )"
     R"(each output that differs, [pipeline.main.failsafe.output.NAME])"},
    {"output_entry_that_is_no_table", 10,
     R"([pipeline.main.failsafe.output]
servos = "hold")",
     R"(t.toml:11:10: "servos" in [pipeline.main.failsafe.output] is "hold"; allowed: a )"
     R"(table, [pipeline.main.failsafe.output.NAME])"},
    {"output_misspelt", 10,
     R"([pipeline.main.failsafe.output.servo]
action = "hold")",
     R"(t.toml:10:32: [pipeline.main] has no output "servo"; did you mean "servos"? )"
     R"(Allowed: "servos")"},
    {"output_of_another_pipeline", 10,
     R"([pipeline.main.failsafe.output.receiver]
action = "hold")",
     R"(t.toml:10:32: [pipeline.main] has no output "receiver"; allowed: "servos")"},
};

INSTANTIATE_TEST_SUITE_P(Mistakes, MistakeInFailsafe, ::testing::ValuesIn(kMistakes),
                         [](const auto& mistake) { return std::string(mistake.param.name); });

std::string motors(std::string_view settings, std::string_view failsafe) {
    return "[input.rx]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n"
           "[output.esc]\nprotocol = \"dronecan\"\ninterface = \"can0\"\nnode_id = 42\n"
           "carries = \"motors\"\n" +
           std::string(settings) +
           "[pipeline.main]\nfrom = \"rx\"\nto = \"esc\"\n[pipeline.main.failsafe]\n" +
           std::string(failsafe);
}

std::string unwritten(std::string_view channel, std::string_view by_default,
                      std::string_view standstill) {
    return "\"action\" is \"preset\", but the preset of channel " + std::string(channel) +
           " is not written: output \"esc\" drives motors, and they would get the default, " +
           std::string(by_default) + " us, where " + std::string(standstill) +
           " us is standstill; write a preset for each of them, such as preset = { other = " +
           std::string(standstill) + " }, or leave \"action\" out";
}

/// The default preset, 1500 us, is half throttle; 988 us on channel 3 of reversible motors is full
/// reverse.
TEST(PresetsOfMotors, MustBeWritten) {
    using Lines = std::vector<std::string>;
    EXPECT_EQ(mistakes_in(motors("", "action = \"preset\"\n")),
              Lines{"t.toml:13:10: " + unwritten("1", "1500", "1000")});
    EXPECT_EQ(mistakes_in(motors("reversible = true\n", "action = \"preset\"\n")),
              Lines{"t.toml:14:10: " + unwritten("3", "988", "1500")});
    EXPECT_EQ(mistakes_in(motors("", "action = \"preset\"\npreset = { 1 = 1000, 2 = 1000 }\n")),
              Lines{"t.toml:13:10: " + unwritten("3", "1500", "1000")});
    EXPECT_EQ(mistakes_in(motors("", "action = \"preset\"\npreset = { other = 1000 }\n")), Lines{});
    EXPECT_EQ(mistakes_in(motors("channels = 1\n", "action = \"preset\"\npreset = { 1 = 1000 }\n")),
              Lines{});
    EXPECT_EQ(mistakes_in(motors("", "action = \"silence\"\n")), Lines{});
    EXPECT_EQ(mistakes_in(motors("", "")), Lines{});
}

constexpr std::string_view kAction = "action = \"preset\"\n";

TEST(PresetsOfMotors, AreAskedForByTheirChannels) {
    using Lines = std::vector<std::string>;
    const auto with = [](std::string_view settings, std::string_view presets) {
        return mistakes_in(motors(settings, std::string(kAction) + std::string(presets)));
    };
    EXPECT_EQ(with("channels = 2\n", "preset = { 1 = 1000, 2 = 1200 }\n"), Lines{});
    EXPECT_EQ(with("channels = 2\n", "preset = { 2 = 1000 }\n"),
              Lines{"t.toml:14:10: " + unwritten("1", "1500", "1000")});
    EXPECT_EQ(with("channels = 2\n", "preset = { 1 = 1200 }\n"),
              Lines{"t.toml:14:10: " + unwritten("2", "1500", "1000")});
}

TEST(PresetsOfMotors, AreNotAskedForWhereTheOthersStandStill) {
    for (const std::string_view count : {"1", "2"}) {
        EXPECT_EQ(mistakes_in(motors("reversible = true\nchannels = " + std::string(count) + "\n",
                                     kAction)),
                  std::vector<std::string>{});
    }
}

TEST(PresetOfOneMotor, IsAskedForBesideThoseOfOtherChannels) {
    const auto found = mistakes_in(motors("channels = 1\n", kAction));
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NE(found[0].find("such as preset = { 1 = 1000, other = 1500 }, or"), std::string::npos)
        << found[0];
}

TEST(PresetsOfMotors, AreNotMissingWhereTheyAreMisspelt) {
    for (const std::string_view presets :
         {"preset = 1500\n", "preset = { othr = 1000 }\n",
          "[pipeline.main.failsafe.output.esc]\npreset = 1500\n"}) {
        EXPECT_EQ(mistakes_in(motors("", std::string(kAction) + std::string(presets))).size(), 1U)
            << presets;
    }
}

TEST(HoldWithoutAMark, IsAtMost300MillisecondsUnlessForced) {
    using Lines = std::vector<std::string>;
    const auto held = [](std::string_view output, std::string_view hold) {
        return main_job_with(5, output) + "[pipeline.main.failsafe]\nhold = \"" +
               std::string(hold) + "\"\n";
    };
    EXPECT_EQ(mistakes_in(held("protocol = \"ibus\"", "301ms")),
              Lines{"t.toml:11:8: \"hold\" is \"301ms\", but \"ibus\" of output \"servos\" cannot "
                    "mark held values: for so long its receiver takes old values for fresh ones; "
                    "allowed there: at most \"300ms\", or add force = true to [output.servos]"});
    EXPECT_EQ(mistakes_in(held("protocol = \"ibus\"", "300ms")), Lines{});
    EXPECT_EQ(mistakes_in(held("protocol = \"ibus\"\nforce = true", "2s")), Lines{});
    EXPECT_EQ(mistakes_in(held("protocol = \"sbus\"", "2s")), Lines{});
}

}  // namespace
}  // namespace tribus::test::mistakes_in_failsafe_test
