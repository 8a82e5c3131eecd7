#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "tests/unit/config/main_job.h"

/// How a pipeline chooses among its inputs, and how its outputs leave failsafe.
namespace tribus::test::selection_test {
namespace {

/// Three inputs and one output. [pipeline.main] starts in line 14 and contains `lines`.
std::string three_with(std::string_view lines, std::string_view from = R"(["a", "b", "c"])") {
    std::string text;
    for (const std::string name : {"a", "b", "c"}) {
        text += "[input." + name + "]\nprotocol = \"ibus\"\ndevice = \"/dev/tty" + name + "\"\n";
    }
    text += "[output.out]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyOut\"\n[pipeline.main]\n";
    text += "to = \"out\"\nfrom = " + std::string(from) + "\n";
    return text + std::string(lines) + "\n";
}

PipelineConfig pipeline_with(std::string_view lines) {
    const auto configuration = load_configuration(three_with(lines), "t.toml");
    if (!configuration) {
        ADD_FAILURE() << format_mistake(configuration.error().front());
        return {};
    }
    return configuration->pipelines.at(0);
}

TEST(Selection, IsByPriorityWhereNobodySaysOtherwise) {
    const SelectionSettings selection = pipeline_with("").selection;
    EXPECT_EQ(selection.mode, SelectionMode::priority);
    EXPECT_EQ(selection.inputs, (std::vector<std::size_t>{0, 1, 2}));
    EXPECT_FALSE(selection.handover);
    EXPECT_FALSE(selection.changeover_us_per_second);
}

TEST(Selection, HasFourModes) {
    EXPECT_EQ(pipeline_with("mode = \"sticky\"").selection.mode, SelectionMode::sticky);
    EXPECT_EQ(pipeline_with("mode = \"freshest\"").selection.mode, SelectionMode::freshest);
    EXPECT_EQ(pipeline_with("mode = \"median\"").selection.mode, SelectionMode::median);
    EXPECT_EQ(pipeline_with("mode = \"priority\"").selection.mode, SelectionMode::priority);
}

TEST(Selection, ReadsToleranceHandoverAndChangeover) {
    const SelectionSettings selection =
        pipeline_with(
            "mode = \"median\"\ntolerance = 30\nchangeover = \"500us/s\"\n"
            "handover = { input = \"b\", channel = 8 }")
            .selection;
    EXPECT_EQ(selection.tolerance, Pulse::from_microseconds(30));
    EXPECT_EQ(selection.changeover_us_per_second, 500);
    ASSERT_TRUE(selection.handover);
    EXPECT_EQ(selection.handover->input, 1U);
    EXPECT_EQ(selection.handover->channel, 7U);
}

TEST(FailsafeExit, ReadsSlewPowerOnAndRelease) {
    const FailsafeSettings failsafe =
        pipeline_with(
            "[pipeline.main.failsafe]\nslew = \"800us/s\"\npower_on = \"5s\"\n"
            "release_when = { channel = 3, below = 1050 }")
            .failsafe.at(0);
    EXPECT_EQ(failsafe.slew_us_per_second, 800);
    EXPECT_EQ(failsafe.power_on, std::chrono::seconds(5));
    ASSERT_TRUE(failsafe.release_when);
    EXPECT_EQ(failsafe.release_when->channel, 2U);
    EXPECT_EQ(failsafe.release_when->below, Pulse::from_microseconds(1050));
}

TEST(FailsafeExit, MayDifferForOneOutput) {
    const FailsafeSettings failsafe = pipeline_with(
                                          "[pipeline.main.failsafe]\npower_on = \"5s\"\n"
                                          "[pipeline.main.failsafe.output.out]\npower_on = \"1s\"")
                                          .failsafe.at(0);
    EXPECT_EQ(failsafe.power_on, std::chrono::seconds(1));
}

struct Wrong {
    std::string_view name;
    std::string_view lines;
    std::string_view from;
    std::string_view expected;
};

class MistakeInSelection : public ::testing::TestWithParam<Wrong> {};

TEST_P(MistakeInSelection, IsReportedWithItsPlaceAndWhatIsAllowed) {
    const Wrong& wrong = GetParam();
    const auto mistakes = mistakes_in(three_with(wrong.lines, wrong.from));
    EXPECT_EQ(mistakes, std::vector<std::string>{std::string(wrong.expected)});
}

constexpr std::string_view kAll = R"(["a", "b", "c"])";

constexpr Wrong kMistakes[]{
    {"mode_misspelt", "mode = \"medium\"", kAll,
     R"(t.toml:16:8: "mode" is "medium"; did you mean "median"? Allowed: "priority", )"
     R"("sticky", "freshest", "median")"},
    {"changeover_where_each_frame_may_be_of_another_input",
     "mode = \"freshest\"\nchangeover = \"500us/s\"", kAll,
     R"(t.toml:17:1: "changeover" has no effect with mode "freshest", where each frame may come )"
     R"(from another input, so every movement would be slowed; leave it out)"},
    {"tolerance_without_a_vote", "tolerance = 40", kAll,
     R"(t.toml:16:1: "tolerance" has no effect: it is for mode = "median"; leave it out)"},
    {"handover_by_an_input_that_is_not_there", "handover = { input = \"d\", channel = 8 }", kAll,
     R"(t.toml:16:22: [pipeline.main] has no input "d"; allowed: "a", "b", "c")"},
    {"handover_without_a_channel", "handover = { input = \"a\" }", kAll,
     R"(t.toml:16:12: "handover" lacks "channel"; required: The channel that selects)"},
    {"handover_that_is_no_table", "handover = 8", kAll,
     R"(t.toml:16:12: "handover" is 8; allowed: a table, such as { input = "main", channel = )"
     R"(8 })"},
    {"release_without_a_limit", "failsafe = { release_when = { channel = 3 } }", kAll,
     R"(t.toml:16:29: "release_when" has no limit; at least one of "below", "above", )"
     R"("between" is required, such as { channel = 3, below = 1050 })"},
};

INSTANTIATE_TEST_SUITE_P(Mistakes, MistakeInSelection, ::testing::ValuesIn(kMistakes),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(MedianOfFewerThanThree, IsAMistake) {
    const std::string text = R"([input.a]
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
mode = "median"
)";
    EXPECT_EQ(mistakes_in(text),
              std::vector<std::string>{
                  R"(t.toml:13:8: "mode" is "median", but [pipeline.main] has 2 inputs: a wrong )"
                  R"(one could not be outvoted; allowed: three or more inputs, or another mode)"});
}

/// A pipeline of so many inputs.
std::string with_inputs(int count) {
    std::string text;
    std::string from;
    for (int i = 1; i <= count; ++i) {
        const std::string number = std::to_string(i);
        text +=
            "[input.in" + number + "]\nprotocol = \"ibus\"\ndevice = \"/dev/tty" + number + "\"\n";
        from += (from.empty() ? "\"in" : ", \"in") + number + "\"";
    }
    text += "[output.out]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyOut\"\n[pipeline.main]\n";
    return text + "from = [" + from + "]\nto = \"out\"\n";
}

TEST(MoreInputsThanAPipelineMayHave, AreAMistake) {
    EXPECT_EQ(mistakes_in(with_inputs(16)), std::vector<std::string>{});
    EXPECT_EQ(mistakes_in(with_inputs(17)),
              std::vector<std::string>{
                  "t.toml:56:8: [pipeline.main] has 17 inputs; allowed: at most 16"});
}

TEST(HandoverOfOneInput, IsAMistake) {
    EXPECT_EQ(mistakes_in(main_job_with(10, "changeover = \"100us/s\"")),
              std::vector<std::string>{
                  R"(t.toml:10:1: "changeover" has no effect: [pipeline.main] has one input; )"
                  R"(leave it out, or name further inputs in "from")"});
}

TEST(MedianOfOne, SaysThatItHasOneInput) {
    EXPECT_EQ(
        mistakes_in(main_job_with(10, "mode = \"median\"")),
        std::vector<std::string>{
            R"(t.toml:10:8: "mode" is "median", but [pipeline.main] has 1 input: a wrong one )"
            R"(could not be outvoted; allowed: three or more inputs, or another mode)"});
}

TEST(TwoInputs, MayHaveAHandoverAndAChangeover) {
    std::string two = three_with(
        "handover = { input = \"b\", channel = 8 }\nchangeover = \"500us/s\"", R"(["a", "b"])");
    two.erase(two.find("[input.c]"), two.find("[output.out]") - two.find("[input.c]"));
    EXPECT_EQ(mistakes_in(two), std::vector<std::string>{});
}

/// The lines of a pipeline and its inputs. There is one mistake in them.
struct Single {
    std::string_view name;
    std::string_view lines;
    std::string_view from;
    std::string_view place;
};

std::ostream& operator<<(std::ostream& out, const Single& single) {
    return out << single.name;
}

class SingleMistakeInSelection : public ::testing::TestWithParam<Single> {};

TEST_P(SingleMistakeInSelection, IsToldWithoutWhatFollowsFromIt) {
    const auto found = mistakes_in(three_with(GetParam().lines, GetParam().from));
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].substr(0, found[0].find(": ")), GetParam().place);
}

constexpr Single kSingle[]{
    {"handover_without_an_input", "handover = { channel = 8 }", kAll, "t.toml:16:12"},
    {"number_for_the_input_of_a_handover", "handover = { input = 5, channel = 8 }", kAll,
     "t.toml:16:22"},
    {"unknown_input_beside_a_handover", "handover = { input = \"d\", channel = 8 }",
     R"(["a", "b", "c", "xyz"])", "t.toml:15:24"},
    {"unknown_input_beside_a_changeover", "changeover = \"500us/s\"", R"(["a", "xyz"])",
     "t.toml:15:14"},
};

INSTANTIATE_TEST_SUITE_P(Mistakes, SingleMistakeInSelection, ::testing::ValuesIn(kSingle),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace tribus::test::selection_test
