#include <gtest/gtest.h>

#include "config/build/build.h"
#include "config/show/effective.h"
#include "tests/unit/config/main_job.h"

/// [gpio.NAME]: its meaning and its mistakes. Its lines come after the nine lines of the main job,
/// from line 10 on.
namespace tribus::test::lines_test {
namespace {

using namespace std::chrono_literals;

Configuration loaded(std::string_view text) {
    auto configuration = load_configuration(text, "t.toml");
    if (!configuration) {
        ADD_FAILURE() << format_mistake(configuration.error().front());
        return {};
    }
    return std::move(*configuration);
}

LineConfig line_with(std::string_view keys) {
    const Configuration configuration = loaded(main_job_with(10, "[gpio.a]\n" + std::string(keys)));
    return configuration.lines.empty() ? LineConfig{} : configuration.lines.front();
}

TEST(Lines, AreFoundByNumberOnAChipByNameAndByNameOnAChip) {
    const GpioPlace by_number = line_with("chip = \"gpiochip0\"\nline = 17\nrole = \"link\"").place;
    EXPECT_EQ(to_text(by_number), "gpiochip0:17");
    EXPECT_EQ(std::get<unsigned>(by_number.line), 17U);
    const GpioPlace by_name = line_with("line = \"GPIO17\"\nrole = \"link\"").place;
    EXPECT_EQ(by_name.chip, "");
    EXPECT_EQ(std::get<std::string>(by_name.line), "GPIO17");
    const GpioPlace both =
        line_with("chip = \"/dev/gpiochip1\"\nline = \"17\"\nrole=\"link\"").place;
    EXPECT_EQ(both.chip, "/dev/gpiochip1");
    EXPECT_EQ(std::get<std::string>(both.line), "17");
}

TEST(Lines, HaveDefaults) {
    const LineConfig line = line_with("line = \"A\"\nrole = \"force_failsafe\"");
    EXPECT_FALSE(line.active_low);
    EXPECT_EQ(line.bias, GpioBias::as_is);
    EXPECT_EQ(line.task.debounce, 20ms);
    EXPECT_EQ(line.task.outputs, std::vector<std::size_t>{0});
    EXPECT_EQ(line_with("line = \"A\"\nrole = \"fresh\"").task.period, 40ms);
}

TEST(Lines, HaveEightRoles) {
    EXPECT_EQ(line_with("line = \"A\"\nrole = \"link\"").task.role, LineRole::link);
    EXPECT_EQ(line_with("line = \"A\"\nrole = \"failsafe\"").task.role, LineRole::failsafe);
    EXPECT_EQ(line_with("line = \"A\"\nrole = \"fresh\"").task.role, LineRole::fresh);
    EXPECT_EQ(line_with("line = \"A\"\nrole = \"inverter\"").task.role, LineRole::inverter);
    const LineConfig force = line_with(
        "line = \"A\"\nrole = \"force_failsafe\"\nbias = \"pull_down\"\ndebounce = \"5ms\"\n"
        "active_low = true\noutput = \"servos\"");
    EXPECT_EQ(force.task.role, LineRole::force_failsafe);
    EXPECT_EQ(force.bias, GpioBias::pull_down);
    EXPECT_EQ(force.task.debounce, 5ms);
    EXPECT_TRUE(force.active_low);
    const LineConfig lever = line_with(
        "line = \"A\"\nrole = \"switch\"\noutput = \"servos\"\nchannel = 9\nabove = 1700\n"
        "between = [900, 1000]");
    EXPECT_EQ(lever.task.role, LineRole::channel_switch);
    EXPECT_EQ(lever.task.rule.channel, 8U);
    EXPECT_EQ(lever.task.rule.above, Pulse::from_microseconds(1700));
    EXPECT_TRUE(lever.task.rule.matches(Pulse::from_microseconds(1000)));
    EXPECT_FALSE(lever.task.rule.matches(Pulse::from_microseconds(1500)));
}

constexpr std::string_view kTwoReceivers = R"([input.a]
protocol = "ibus"
device = "/dev/ttyA"
[input.b]
protocol = "ibus"
device = "/dev/ttyB"
[output.out]
protocol = "sbus"
device = "/dev/ttyOut"
[pipeline.main]
from = ["a", "b"]
to = "out"
)";

TEST(Lines, SelectAnInput) {
    const Configuration configuration = loaded(
        std::string(kTwoReceivers) + "[gpio.s]\nline = \"A\"\nrole = \"select\"\ninput = \"b\"\n");
    ASSERT_EQ(configuration.lines.size(), 1U);
    EXPECT_EQ(configuration.lines[0].task.role, LineRole::select);
    EXPECT_EQ(configuration.lines[0].task.input, 1U);
}

TEST(Lines, WithButtonsAreSourcesOfChannels) {
    const Configuration configuration = loaded(main_job_with(
        10,
        "[pipeline.main.channels]\n12 = { line = \"bind\" }\n[gpio.lamp]\nline = \"B\"\n"
        "role = \"link\"\n[gpio.bind]\nline = \"A\"\nrole = \"button\""));
    ASSERT_EQ(configuration.pipelines.size(), 1U);
    const ChannelRule& rule = configuration.pipelines[0].channels.at(0);
    EXPECT_EQ(rule.output, 11U);
    EXPECT_EQ(std::get<FromLine>(rule.source).line, 1U);
    EXPECT_EQ(build_engine(configuration)->outputs().size(), 1U);
}

TEST(Lines, ShowInTheEffectiveConfigurationWhatTheirRoleHas) {
    const std::string text = effective_toml(loaded(
        std::string(kTwoReceivers) +
        "[pipeline.main.channels]\n12 = { line = \"bind\" }\n"
        "[gpio.s]\nline = \"A\"\nrole = \"select\"\ninput = \"b\"\n"
        "[gpio.bind]\nchip = \"gpiochip0\"\nline = 3\nrole = \"button\"\nbias = \"pull_up\"\n"
        "[gpio.gate]\nline = \"B\"\nrole = \"fresh\"\n"
        "[gpio.lever]\nline = \"C\"\nrole = \"switch\"\noutput = \"out\"\nchannel = 9\n"
        "below = 1200\n"));
    const std::string lines = text.substr(std::min(text.size(), text.find("[gpio.s]")));
    EXPECT_EQ(lines, R"([gpio.s]
line = "A"
role = "select"
active_low = false
bias = "as_is"
debounce = "20ms"
input = "b"

[gpio.bind]
chip = "gpiochip0"
line = 3
role = "button"
active_low = false
bias = "pull_up"
debounce = "20ms"

[gpio.gate]
line = "B"
role = "fresh"
active_low = false
output = "out"
period = "40ms"

[gpio.lever]
line = "C"
role = "switch"
active_low = false
output = "out"
channel = 9
below = 1200
)");
    EXPECT_NE(text.find("12 = { line = \"bind\" }"), std::string::npos) << text;
}

class MistakeInLines : public ::testing::TestWithParam<Spoilt> {};

TEST_P(MistakeInLines, IsReportedWithItsPlaceAndWhatIsAllowed) {
    const Spoilt& spoilt = GetParam();
    EXPECT_EQ(mistakes_in(main_job_with(spoilt.line, spoilt.replacement)),
              std::vector<std::string>{std::string(spoilt.expected)});
}

constexpr Spoilt kMistakes[]{
    {"number_without_a_chip", 10, "[gpio.a]\nline = 17\nrole = \"link\"",
     R"(t.toml:11:8: "line" is 17, a number without a chip; add "chip", such as chip = )"
     R"("gpiochip0", or give the line's name)"},
    {"negative_number", 10, "[gpio.a]\nchip = \"gpiochip0\"\nline = -1\nrole = \"link\"",
     R"(t.toml:12:8: "line" is -1; allowed: the number of a line on its chip, from 0, or a name, )"
     R"(such as "GPIO17")"},
    {"digits_in_quotes", 10, "[gpio.a]\nline = \"17\"\nrole = \"link\"",
     R"(t.toml:11:8: "line": "17" is an offset without its chip: give a line's name, such as )"
     R"("GPIO17", or chip and offset, such as "gpiochip0:17")"},
    {"role_misspelt", 10, "[gpio.a]\nline = \"A\"\nrole = \"fialsafe\"",
     R"(t.toml:12:8: "role" is "fialsafe"; did you mean "failsafe"? Allowed: "link", )"
     R"("failsafe", "fresh", "force_failsafe", "select", "inverter", "button", "switch")"},
    {"key_of_another_role", 10, "[gpio.a]\nline = \"A\"\nrole = \"link\"\ndebounce = \"5ms\"",
     R"(t.toml:13:1: "debounce" has no effect with role "link": it is for "force_failsafe", )"
     R"("select", "button"; leave it out)"},
    {"range_of_a_lamp", 10, "[gpio.a]\nline = \"A\"\nrole = \"link\"\nbetween = [1000, 1200]",
     R"(t.toml:13:1: "between" has no effect with role "link": it is for "switch"; leave it out)"},
    {"output_misspelt", 10, "[gpio.a]\nline = \"A\"\nrole = \"link\"\noutput = \"servo\"",
     R"(t.toml:13:10: no output is named "servo"; did you mean "servos"? Allowed: "servos")"},
    {"select_without_an_input", 10, "[gpio.a]\nline = \"A\"\nrole = \"select\"",
     R"(t.toml:10:1: [gpio.a] lacks "input"; required with role "select", such as input = )"
     R"("backup")"},
    {"select_with_nothing_to_choose", 10,
     "[gpio.a]\nline = \"A\"\nrole = \"select\"\ninput = \"receiver\"",
     R"(t.toml:10:7: line "a" selects input "receiver", but no pipeline has that input and a )"
     R"(second one to select from; name further inputs in its "from", or leave the line out)"},
    {"switch_without_a_limit", 10,
     "[gpio.a]\nline = \"A\"\nrole = \"switch\"\noutput = \"servos\"\nchannel = 9",
     R"(t.toml:10:1: [gpio.a] has no limit; at least one of "below", "above", "between" is )"
     R"(required with role "switch", such as channel = 9, above = 1700)"},
    {"switch_without_an_output", 10,
     "[gpio.a]\nline = \"A\"\nrole = \"switch\"\nchannel = 9\nabove = 1700",
     R"(t.toml:10:1: [gpio.a] lacks "output"; required with role "switch", such as output = )"
     R"("servos")"},
    {"switch_that_is_always_on", 10,
     "[gpio.a]\nline = \"A\"\nrole = \"switch\"\noutput = \"servos\"\nchannel = 9\nabove = 1700\n"
     "below = 1800",
     R"(t.toml:15:9: "below" is 1800 and "above" is 1700, so it would always be on; allowed: )"
     R"("below" less than "above")"},
    {"wave_faster_than_the_frames", 10,
     "[gpio.a]\nline = \"A\"\nrole = \"fresh\"\nperiod = \"20ms\"",
     R"(t.toml:13:10: the period of the wave of line "a" is "20ms", but output "servos" sends )"
     R"(every "14ms": some half periods of the wave would have no frame; allowed: at least )"
     R"("28ms", recommended: "56ms")"},
    {"wave_faster_than_the_frames_by_default", 6,
     "device = \"/dev/ttyB\"\nperiod = \"50ms\"\n[gpio.a]\nline = \"A\"\nrole = \"fresh\"",
     R"(t.toml:8:7: the period of the wave of line "a" is "40ms" by default, but output )"
     R"("servos" sends every "50ms": some half periods of the wave would have no frame; )"
     R"(allowed: at least "100ms", recommended: "200ms")"},
    {"line_used_twice_by_name", 10,
     "[gpio.a]\nline = \"A\"\nrole = \"link\"\n[gpio.b]\nchip = \"gpiochip3\"\nline = \"A\"\n"
     "role = \"failsafe\"",
     R"(t.toml:15:8: line "gpiochip3:A" is already used by [gpio.a] in line 11 of the file; a )"
     R"(line has one role)"},
    {"line_used_twice_by_number", 10,
     "[gpio.a]\nchip = \"gpiochip3\"\nline = 1\nrole = \"link\"\n[gpio.b]\n"
     "chip = \"/dev/gpiochip3\"\nline = 1\nrole = \"failsafe\"",
     R"(t.toml:16:8: line "/dev/gpiochip3:1" is already used by [gpio.a] in line 12 of the file; )"
     R"(a line has one role)"},
    {"button_without_a_channel", 10, "[gpio.a]\nline = \"A\"\nrole = \"button\"",
     R"(t.toml:10:7: no channel is made from button "a", so it would have no effect; name it in )"
     R"([pipeline.NAME.channels], such as 12 = { line = "a" }, or leave it out)"},
    {"channel_from_no_line", 10, "[pipeline.main.channels]\n3 = { line = \"a\" }",
     R"(t.toml:11:14: no line with role "button" is named "a"; add a [gpio.a] with role = )"
     R"("button")"},
    {"channel_from_a_misspelt_line", 10,
     "[pipeline.main.channels]\n3 = { line = \"bnid\" }\n[gpio.bind]\nline = \"A\"\n"
     "role = \"button\"",
     R"(t.toml:11:14: no line with role "button" is named "bnid"; did you mean "bind"? Allowed: )"
     R"("bind")"},
    {"channel_from_a_line_with_a_shape", 10,
     "[pipeline.main.channels]\n3 = { line = \"bind\", trim = 5 }\n[gpio.bind]\nline = \"A\"\n"
     "role = \"button\"",
     R"(t.toml:11:22: "trim" has no effect together with "line"; leave one of them out)"},
    {"period_of_a_lamp", 10, "[gpio.a]\nline = \"A\"\nrole = \"link\"\nperiod = \"1s\"",
     R"(t.toml:13:1: "period" has no effect with role "link": it is for "fresh"; leave it out)"},
    {"switch_without_a_channel", 10,
     "[gpio.a]\nline = \"A\"\nrole = \"switch\"\noutput = \"servos\"\nabove = 1700",
     R"(t.toml:10:1: [gpio.a] lacks "channel"; required with role "switch", such as channel = 9, )"
     R"(above = 1700)"},
    {"one_of_two_buttons_without_a_channel", 10,
     "[pipeline.main.channels]\n12 = { line = \"used\" }\n[gpio.used]\nline = \"A\"\n"
     "role = \"button\"\n[gpio.a]\nline = \"B\"\nrole = \"button\"",
     R"(t.toml:15:7: no channel is made from button "a", so it would have no effect; name it in )"
     R"([pipeline.NAME.channels], such as 12 = { line = "a" }, or leave it out)"},
    {"channel_from_a_misspelt_line_behind_another", 10,
     "[pipeline.main.channels]\n3 = { line = \"bnid\" }\n[gpio.lamp]\nline = \"B\"\n"
     "role = \"link\"\n[gpio.bind]\nline = \"A\"\nrole = \"button\"",
     R"(t.toml:11:14: no line with role "button" is named "bnid"; did you mean "bind"? Allowed: )"
     R"("bind")"},
    {"channel_from_a_lamp", 10,
     "[pipeline.main.channels]\n3 = { line = \"lamp\" }\n[gpio.lamp]\nline = \"B\"\n"
     "role = \"link\"",
     R"(t.toml:11:14: no line with role "button" is named "lamp"; add a [gpio.lamp] with role = )"
     R"("button")"},
    {"line_in_the_map_of_an_input", 3, "device = \"/dev/ttyA\"\nmap = { 3 = { line = \"a\" } }",
     R"(t.toml:4:15: "line" makes a channel of an output; it is only allowed in )"
     R"([pipeline.NAME.channels])"},
    {"line_without_a_name", 10, "[gpio]\nline = 5",
     R"(t.toml:11:1: "line" stands in [gpio] itself; allowed: tables with a name, [gpio.NAME])"},
    {"debounce_of_an_input", 3, "device = \"/dev/ttyA\"\ndebounce = \"5ms\"",
     R"(t.toml:4:1: unknown key "debounce" in [input.receiver]; it belongs in [gpio.NAME]; )"
     R"(allowed: "protocol", "device", "timeout", "failsafe_flag", "frame_lost_flag", )"
     R"("frame_lost_run", "frame_lost_ratio", "failsafe_when", "frozen", "plausible", )"
     R"("zero_guard", "map", "baud", "slots")"},
};

INSTANTIATE_TEST_SUITE_P(Mistakes, MistakeInLines, ::testing::ValuesIn(kMistakes),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(ButtonsOfChannelsThatCannotBeRead, AreNotCalledUnused) {
    const std::string button = "[gpio.a]\nline = \"A\"\nrole = \"button\"";
    EXPECT_EQ(mistakes_in(main_job_with(10, "channels = 5\n" + button)).size(), 1U);
    EXPECT_EQ(
        mistakes_in(main_job_with(10, "[pipeline.main.channels]\n19 = { line = \"a\" }\n" + button))
            .size(),
        1U);
}

TEST(MoreLinesThanAWordHasBits, AreAMistake) {
    std::string lines;
    for (int i = 0; i < 33; ++i) {
        lines += "[gpio.l" + std::to_string(i) + "]\nline = \"L" + std::to_string(i) +
                 "\"\nrole = \"link\"\n";
    }
    EXPECT_EQ(mistakes_in(main_job_with(10, lines)),
              std::vector<std::string>{"t.toml:106:7: there are 33 lines; allowed: at most 32"});
}

constexpr std::string_view kLegs = R"([input.receiver]
protocol = "ibus"
device   = "/dev/a"
[output.lamps]
protocol = "sbus"
device   = "/dev/b"
[output.legs]
protocol      = "pwm"
chip          = "pca9685-pwm"
outputs       = { 1 = 0 }
period        = "10ms"
output_enable = "GPIO22"
[pipeline.main]
from = "receiver"
to   = ["lamps", "legs"]
)";

TEST(OutputEnable, IsTheLineOfTheFreshnessWaveOfItsOutput) {
    const Configuration configuration = loaded(kLegs);
    ASSERT_EQ(configuration.lines.size(), 1U);
    const LineConfig& line = configuration.lines.front();
    EXPECT_EQ(line.name, "legs.output_enable");
    EXPECT_EQ(to_text(line.place), "GPIO22");
    EXPECT_EQ(line.task.role, LineRole::fresh);
    EXPECT_EQ(line.task.outputs, std::vector<std::size_t>{1});
    EXPECT_EQ(line.task.period, 40ms);
}

TEST(OutputEnable, IsShownAsTheKeyOfItsOutput) {
    const std::string text = effective_toml(loaded(kLegs));
    EXPECT_NE(text.find("output_enable = \"GPIO22\""), std::string::npos) << text;
    EXPECT_EQ(text.find("[gpio"), std::string::npos) << text;
    EXPECT_EQ(loaded(text).lines, loaded(kLegs).lines);
}

TEST(OutputEnable, HasAWaveThatIsNoLongerThanItsGateCanBe) {
    std::string text(kLegs);
    text.replace(text.find("10ms\""), 5, "1s\"");
    text.replace(text.find("/dev/a\""), 7, "/dev/a\"\ntimeout = \"5s\"");
    EXPECT_EQ(loaded(text).lines.front().task.period, 2s);
}

TEST(OutputEnable, IsRefusedIfItNamesNoLine) {
    std::string text(kLegs);
    text.replace(text.find("GPIO22"), 6, "gpiochip0:");
    const auto refused = load_configuration(text, "t.toml");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().size(), 1U);
    EXPECT_EQ(format_mistake(refused.error().front()).rfind("t.toml:12:17: \"output_enable\": ", 0),
              0U)
        << format_mistake(refused.error().front());
}

TEST(OutputEnable, IsRefusedIfItsLineHasARole) {
    const auto refused = load_configuration(
        std::string(kLegs) + "[gpio.lamp]\nline = \"GPIO22\"\nrole = \"link\"\n", "t.toml");
    ASSERT_FALSE(refused);
    EXPECT_EQ(format_mistake(refused.error().front()),
              "t.toml:12:17: line \"GPIO22\" is already used by [gpio.lamp] in line 17 of the "
              "file; a line has one role");
}

}  // namespace
}  // namespace tribus::test::lines_test
