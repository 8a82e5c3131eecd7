#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

namespace tribus::test::mistakes_in_channels_test {
namespace {

class MistakeInChannels : public ::testing::TestWithParam<Spoilt> {};

TEST_P(MistakeInChannels, IsReportedWithItsPlaceAndWhatIsAllowed) {
    const Spoilt& spoilt = GetParam();
    const auto mistakes = mistakes_in(main_job_with(spoilt.line, spoilt.replacement));
    EXPECT_EQ(mistakes, std::vector<std::string>{std::string(spoilt.expected)});
}

constexpr Spoilt kMistakes[]{
    {"output_channel_0", 10,
     R"([pipeline.main.channels]
0 = 1)",
     R"(t.toml:11:1: "0" is not an output channel; allowed: channel numbers from 1 to 18)"},
    {"output_channel_19", 10,
     R"([pipeline.main.channels]
19 = 1)",
     R"(t.toml:11:1: "19" is not an output channel; allowed: channel numbers from 1 to )"
     R"(18)"},
    {"output_channel_with_a_leading_zero", 10,
     R"([pipeline.main.channels]
01 = 1)",
     R"(t.toml:11:1: "01" is not an output channel; allowed: channel numbers from 1 to )"
     R"(18)"},
    {"output_channel_that_is_a_word", 10,
     R"([pipeline.main.channels]
throttle = 3)",
     R"(t.toml:11:1: "throttle" is not an output channel; allowed: channel numbers from )"
     R"(1 to 18)"},
    {"input_channel_0", 10,
     R"([pipeline.main.channels]
1 = 0)",
     R"(t.toml:11:5: channel 1 is 0; allowed: the number of an input channel from 1 to )"
     R"(18, or a table such as { from = 1, reverse = true })"},
    {"input_channel_19", 10,
     R"([pipeline.main.channels]
1 = 19)",
     R"(t.toml:11:5: channel 1 is 19; allowed: the number of an input channel from 1 to )"
     R"(18, or a table such as { from = 1, reverse = true })"},
    {"channel_as_text", 10,
     R"([pipeline.main.channels]
1 = "2")",
     R"(t.toml:11:5: channel 1 is "2"; allowed: the number of an input channel from 1 )"
     R"(to 18, without quotes, or a table such as { from = 1, reverse = true })"},
    {"empty_entry", 10,
     R"([pipeline.main.channels]
1 = {})",
     R"(t.toml:11:5: channel 1 has no source; exactly one of "from", "mix", "fixed", "line" is )"
     R"(required)"},
    {"two_sources", 10,
     R"([pipeline.main.channels]
1 = { from = 1, fixed = 1500 })",
     R"(t.toml:11:5: channel 1 has "from", "fixed"; exactly one of "from", "mix", )"
     R"("fixed", "line" is required)"},
    {"from_out_of_range", 10,
     R"([pipeline.main.channels]
1 = { from = 19 })",
     R"(t.toml:11:14: "from" is 19; allowed: a whole number from 1 to 18)"},
    {"unknown_key_in_an_entry", 10,
     R"([pipeline.main.channels]
1 = { from = 1, revers = true })",
     R"(t.toml:11:17: unknown key "revers" in channel 1; did you mean "reverse"? )"
     R"(Allowed: "from", "mix", "fixed", "line", "above", "below", "reverse", "trim", "expo", )"
     R"("deadband", "slew", "min", "max")"},
    {"reverse_as_a_number", 10,
     R"([pipeline.main.channels]
1 = { from = 1, reverse = 1 })",
     R"(t.toml:11:27: "reverse" is 1; allowed: true or false)"},
    {"trim_out_of_range", 10,
     R"([pipeline.main.channels]
1 = { from = 1, trim = 501 })",
     R"(t.toml:11:24: "trim" is 501; allowed: microseconds from -500 to 500)"},
    {"expo_out_of_range", 10,
     R"([pipeline.main.channels]
1 = { from = 1, expo = 1.1 })",
     R"(t.toml:11:24: "expo" is 1.1; allowed: a number from 0 to 1)"},
    {"expo_that_is_no_number", 10,
     R"([pipeline.main.channels]
1 = { from = 1, expo = nan })",
     R"(t.toml:11:24: "expo" is nan; allowed: a number from 0 to 1)"},
    {"deadband_negative", 10,
     R"([pipeline.main.channels]
1 = { from = 1, deadband = -1 })",
     R"(t.toml:11:28: "deadband" is -1; allowed: microseconds from 0 to 200)"},
    {"slew_without_a_unit", 10,
     R"([pipeline.main.channels]
1 = { from = 1, slew = 2000 })",
     R"(t.toml:11:24: "slew" is 2000; allowed: microseconds per second from "1us/s" to )"
     R"("1000000us/s", text such as "2000us/s")"},
    {"slew_of_zero", 10,
     R"([pipeline.main.channels]
1 = { from = 1, slew = "0us/s" })",
     R"(t.toml:11:24: "slew" is "0us/s"; allowed: microseconds per second from "1us/s" to )"
     R"("1000000us/s", text such as "2000us/s")"},
    {"min_out_of_range", 10,
     R"([pipeline.main.channels]
1 = { from = 1, min = 499.9 })",
     R"(t.toml:11:23: "min" is 499.9; allowed: microseconds from 500 to 2500)"},
    {"min_not_below_max", 10,
     R"([pipeline.main.channels]
1 = { from = 1, min = 1500, max = 1500 })",
     R"(t.toml:11:35: "min" is 1500 and "max" is 1500, so no value would be allowed; )"
     R"(allowed: "min" less than "max")"},
    {"fixed_out_of_range", 10,
     R"([pipeline.main.channels]
1 = { fixed = 2501 })",
     R"(t.toml:11:15: "fixed" is 2501; allowed: microseconds from 500 to 2500)"},
    {"fixed_with_a_shape", 10,
     R"([pipeline.main.channels]
1 = { fixed = 1500, trim = 10 })",
     R"(t.toml:11:21: "trim" has no effect together with "fixed"; leave one of them out)"},
    {"switch_without_from", 10,
     R"([pipeline.main.channels]
1 = { mix = { 1 = 1 }, above = 1700 })",
     R"(t.toml:11:24: "above" makes a switch from one input channel; it is only allowed with )"
     R"("from")"},
    {"switch_with_a_shape", 10,
     R"([pipeline.main.channels]
1 = { from = 1, below = 1300, expo = 0.5 })",
     R"(t.toml:11:31: "expo" has no effect together with "below"; leave one of them out)"},
    {"switch_that_is_always_on", 10,
     R"([pipeline.main.channels]
1 = { from = 1, below = 1700, above = 1300 })",
     R"(t.toml:11:39: "below" is 1700 and "above" is 1300, so the switch would always )"
     R"(be on; allowed: "below" less than "above")"},
    {"empty_mix", 10,
     R"([pipeline.main.channels]
1 = { mix = {} })",
     R"(t.toml:11:13: "mix" is empty; allowed: a table of weights by channel number, )"
     R"(such as { 1 = 0.5, 2 = -0.5 })"},
    {"mix_of_a_wrong_type", 10,
     R"([pipeline.main.channels]
1 = { mix = [1, 2] })",
     R"(t.toml:11:13: "mix" is [1, 2]; allowed: a table of weights by channel number, )"
     R"(such as { 1 = 0.5, 2 = -0.5 })"},
    {"mix_with_a_channel_out_of_range", 10,
     R"([pipeline.main.channels]
1 = { mix = { 19 = 1 } })",
     R"(t.toml:11:15: "19" in "mix" is not a channel; allowed: channel numbers from 1 )"
     R"(to 18)"},
    {"mix_with_a_weight_out_of_range", 10,
     R"([pipeline.main.channels]
1 = { mix = { 1 = 10.5 } })",
     R"(t.toml:11:19: the weight of channel 1 is 10.5; allowed: a number from -10 to 10)"},
    {"mix_with_a_weight_as_text", 10,
     R"([pipeline.main.channels]
1 = { mix = { 1 = "half" } })",
     R"(t.toml:11:19: the weight of channel 1 is "half"; allowed: a number from -10 to )"
     R"(10)"},
    {"channels_that_are_no_table", 10, "channels = 5",
     R"(t.toml:10:12: [pipeline.main.channels] is 5; allowed: a table, such as { 1 = 2 })"},
};

INSTANTIATE_TEST_SUITE_P(Mistakes, MistakeInChannels, ::testing::ValuesIn(kMistakes),
                         [](const auto& mistake) { return std::string(mistake.param.name); });

}  // namespace
}  // namespace tribus::test::mistakes_in_channels_test
