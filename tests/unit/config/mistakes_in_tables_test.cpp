#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

namespace tribus::test::mistakes_in_tables_test {
namespace {

class MistakeInTables : public ::testing::TestWithParam<Spoilt> {};

TEST_P(MistakeInTables, IsReportedWithItsPlaceAndWhatIsAllowed) {
    const Spoilt& spoilt = GetParam();
    const auto mistakes = mistakes_in(main_job_with(spoilt.line, spoilt.replacement));
    EXPECT_EQ(mistakes, std::vector<std::string>{std::string(spoilt.expected)});
}

constexpr Spoilt kMistakes[]{
    {"misspelt_table", 7, "[pipelin.main]",
     R"(t.toml:7:2: unknown table "pipelin" in the file; did you mean "pipeline"? )"
     R"(Allowed: "runtime", "input", "output", "pipeline", "gpio", )"
     R"("sensor_bus", "sensor_type", "values", "dronecan", "recorder")"},
    {"unknown_table", 10,
     R"([display.lamp]
line = 17)",
     R"(t.toml:10:2: unknown table "display" in the file; allowed: "runtime", "input", )"
     R"("output", "pipeline", "gpio", )"
     R"("sensor_bus", "sensor_type", "values", "dronecan", "recorder")"},
    {"key_outside_of_any_table", 1,
     R"(protocol = "ibus"
[input.receiver])",
     R"(t.toml:1:1: unknown key "protocol" in the file; it belongs in [input.NAME]; )"
     R"(allowed: "runtime", "input", "output", "pipeline", "gpio", )"
     R"("sensor_bus", "sensor_type", "values", "dronecan", "recorder")"},
    {"input_without_a_name", 10,
     R"([input]
protocol = "ibus")",
     R"(t.toml:11:1: "protocol" stands in [input] itself; allowed: tables with a name, )"
     R"([input.NAME])"},
    {"runtime_that_is_no_table", 1,
     R"(runtime = 5
[input.receiver])",
     R"(t.toml:1:11: "runtime" is 5; allowed: a table, [runtime])"},
    {"input_that_is_a_list", 4,
     R"([input]
second = [1]
[output.servos])",
     R"(t.toml:5:1: "second" stands in [input] itself; allowed: tables with a name, )"
     R"([input.NAME])"},
    {"runtime_that_is_a_list", 1,
     R"(runtime = [1]
[input.receiver])",
     R"(t.toml:1:11: "runtime" is [1]; allowed: a table, [runtime])"},
    {"lines_that_are_a_list", 1, "gpio = [1]\n[input.receiver]",
     R"(t.toml:1:8: "gpio" is [1]; allowed: a table with a name, [gpio.NAME])"},
    {"lines_that_are_a_number", 1, "gpio = 5\n[input.receiver]",
     R"(t.toml:1:8: "gpio" is 5; allowed: a table with a name, [gpio.NAME])"},
    {"name_with_a_space", 7, R"([pipeline."main one"])",
     R"(t.toml:7:11: "main one" is not a name; allowed: letters, digits, "_" and "-", )"
     R"(at least one)"},
    {"empty_name", 7, R"([pipeline.""])",
     R"(t.toml:7:11: "" is not a name; allowed: letters, digits, "_" and "-", at least )"
     R"(one)"},
    {"runtime_realtime", 10,
     R"([runtime]
realtime = "on")",
     R"(t.toml:11:12: "realtime" is "on"; allowed: "auto", "off", "require")"},
    {"runtime_priority", 10,
     R"([runtime]
priority = 100)",
     R"(t.toml:11:12: "priority" is 100; allowed: a whole number from 1 to 99)"},
    {"runtime_priority_with_a_fraction", 10,
     R"([runtime]
priority = 80.5)",
     R"(t.toml:11:12: "priority" is 80.5; allowed: a whole number from 1 to 99)"},
    {"runtime_cpu", 10,
     R"([runtime]
cpu = -1)",
     R"(t.toml:11:7: "cpu" is -1; allowed: a whole number from 0 to 255)"},
    {"runtime_misspelt_key", 10,
     R"([runtime]
prioritty = 80)",
     R"(t.toml:11:1: unknown key "prioritty" in [runtime]; did you mean "priority"? )"
     R"(Allowed: "realtime", "priority", "cpu", "spin")"},
    {"runtime_that_is_a_date", 10,
     R"([runtime]
cpu = 2024-02-29)",
     R"(t.toml:11:7: "cpu" is a date or time; allowed: a whole number from 0 to 255)"},
};

INSTANTIATE_TEST_SUITE_P(Mistakes, MistakeInTables, ::testing::ValuesIn(kMistakes),
                         [](const auto& mistake) { return std::string(mistake.param.name); });

TEST(NameOfATable, MayHaveLettersDigitsAndTwoMarks) {
    EXPECT_EQ(mistakes_in(main_job_with(7, "[pipeline.AZ_az-09]")), std::vector<std::string>{});
}

}  // namespace
}  // namespace tribus::test::mistakes_in_tables_test
