#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

namespace tribus::test::mistakes_in_pipelines_test {
namespace {

class MistakeInPipelines : public ::testing::TestWithParam<Spoilt> {};

TEST_P(MistakeInPipelines, IsReportedWithItsPlaceAndWhatIsAllowed) {
    const Spoilt& spoilt = GetParam();
    const auto mistakes = mistakes_in(main_job_with(spoilt.line, spoilt.replacement));
    EXPECT_EQ(mistakes, std::vector<std::string>{std::string(spoilt.expected)});
}

constexpr Spoilt kMistakes[]{
    {"missing_from", 8, "",
     R"(t.toml:7:1: [pipeline.main] lacks "from"; required: Inputs by name, the )"
     R"(preferred one first)"},
    {"missing_to", 9, "", R"(t.toml:7:1: [pipeline.main] lacks "to"; required: Outputs by name)"},
    {"misspelt_input", 8, R"(from = "reciever")",
     R"(t.toml:8:8: no input is named "reciever"; did you mean "receiver"? Allowed: )"
     R"("receiver")"},
    {"unknown_input", 8, R"(from = ["receiver", "x"])",
     R"(t.toml:8:21: no input is named "x"; allowed: "receiver")"},
    {"misspelt_output", 9, R"(to = "servo")",
     R"(t.toml:9:6: no output is named "servo"; did you mean "servos"? Allowed: "servos")"},
    {"unknown_output", 9, R"(to = ["servos", "x"])",
     R"(t.toml:9:17: no output is named "x"; allowed: "servos")"},
    {"from_of_a_wrong_type", 8, "from = 1",
     R"(t.toml:8:8: "from" is 1; allowed: the name of an input, or a list of names)"},
    {"empty_from", 8, "from = []",
     R"(t.toml:8:8: "from" is an empty list; allowed: the name of an input, or a list )"
     R"(of names)"},
    {"number_in_to", 9, R"(to = ["servos", 2])",
     R"(t.toml:9:17: "to" is a list with 2; allowed: the name of an output, or a list )"
     R"(of names)"},
    {"input_listed_twice", 8, R"(from = ["receiver", "receiver"])",
     R"(t.toml:8:21: input "receiver" is listed twice; list it once)"},
    {"output_listed_twice", 9, R"(to = ["servos", "servos"])",
     R"(t.toml:9:17: output "servos" is listed twice; list it once)"},
    {"output_of_two_pipelines", 10,
     R"([pipeline.second]
from = "receiver"
to = "servos")",
     R"(t.toml:12:6: output "servos" is already fed by [pipeline.main]; an output )"
     R"(belongs to one pipeline)"},
    {"unused_input", 10,
     R"([input.spare]
protocol = "ibus"
device = "/dev/ttyC")",
     R"(t.toml:10:8: input "spare" feeds no pipeline, so it would have no effect; name it in )"
     R"(the "from" of a pipeline, or leave it out)"},
    {"unused_output", 10,
     R"([output.spare]
protocol = "ibus"
device = "/dev/ttyC")",
     R"(t.toml:10:9: no pipeline feeds output "spare", so it would have no effect; name it in )"
     R"(the "to" of a pipeline, or leave it out)"},
    {"two_outputs_on_one_device", 9,
     R"(to = ["servos", "b"]
[output.b]
protocol = "sbus"
device = "/dev/ttyB")",
     R"(t.toml:12:10: device "/dev/ttyB" is already used by [output.servos] in line 6; )"
     R"(one device serves at most one input and one output)"},
    {"shared_device_with_other_line_settings", 6, R"(device = "/dev/ttyA")",
     R"(t.toml:6:10: device "/dev/ttyA" is already used by [input.receiver] in line 3 )"
     R"(with 115200 baud 8N1, here with 100000 baud 8E2; an input and an output may )"
     R"(share a device if their line settings agree)"},
    {"timeout_not_longer_than_the_period", 6,
     R"(device = "/dev/ttyB"
period = "100ms")",
     R"(t.toml:7:10: the timeout of input "receiver" is "100ms", but output "servos" )"
     R"(sends every "100ms": each frame would be judged too old; allowed: a timeout )"
     R"(longer than the period)"},
};

INSTANTIATE_TEST_SUITE_P(Mistakes, MistakeInPipelines, ::testing::ValuesIn(kMistakes),
                         [](const auto& mistake) { return std::string(mistake.param.name); });

}  // namespace
}  // namespace tribus::test::mistakes_in_pipelines_test
