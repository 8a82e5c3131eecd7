#include "config/keys/words.h"

#include <array>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/channel_frame.h"

namespace tribus::test::words_test {
namespace {

using enum SettingType;

constexpr std::array<std::string_view, 2> kWords{"a", "b"};
constexpr std::array<std::string_view, 2> kNumbers{"4", "8"};

struct Row {
    std::string_view name;
    Setting setting;
    std::string_view type;
    std::string_view range;
    std::string_view fallback;
};

std::ostream& operator<<(std::ostream& out, const Row& row) {
    return out << row.name;
}

const Row kRows[]{
    {"truth", {.key = "k", .type = boolean, .fallback = "true"}, "true or false", "", "`true`"},
    {"whole_number",
     {.key = "k", .type = integer, .fallback = "1024", .least = 1, .most = 4096},
     "whole number",
     "1 to 4096",
     "`1024`"},
    {"whole_number_with_a_unit",
     {.key = "k", .type = integer, .unit = "KiB"},
     "whole number, KiB",
     "",
     "none"},
    {"whole_number_to_choose",
     {.key = "k", .type = integer, .fallback = "4", .least = 1, .most = 9, .choices = kNumbers},
     "whole number",
     "`4`, `8`",
     "`4`"},
    {"number",
     {.key = "k", .type = number, .fallback = "2.50", .least = -0.5, .most = 1e6},
     "number",
     "-0.5 to 1000000",
     "`2.5`"},
    {"number_with_a_unit", {.key = "k", .type = number, .unit = "V"}, "number, V", "", "none"},
    {"number_up_to_a_limit", {.key = "k", .type = number, .most = 5}, "number", "0 to 5", "none"},
    {"number_down_to_a_limit",
     {.key = "k", .type = number, .least = -5},
     "number",
     "-5 to 0",
     "none"},
    {"text", {.key = "k", .type = text, .fallback = "\"x\""}, "text", "", "`\"x\"`"},
    {"text_that_is_required", {.key = "k", .type = text, .required = true}, "text", "", "required"},
    {"text_whose_absence_means_something",
     {.key = "k", .type = text, .absent = "as `x`"},
     "text",
     "",
     "as `x`"},
    {"word",
     {.key = "k", .type = choice, .fallback = "\"a\"", .choices = kWords},
     "text",
     "`\"a\"`, `\"b\"`",
     "`\"a\"`"},
    {"time",
     {.key = "k", .type = duration, .fallback = "\"20ms\"", .least = 0.0005, .most = 10},
     "duration",
     "`\"500us\"` to `\"10s\"`",
     "`\"20ms\"`"},
    {"pulse_width",
     {.key = "k", .type = pulse, .fallback = "1500", .least = 500, .most = 2500},
     "number, us",
     "500 to 2500",
     "`1500`"},
    {"two_pulse_widths",
     {.key = "k", .type = pulses, .fallback = "[800, 2200.5]", .least = 0, .most = 4095},
     "two numbers, us",
     "0 to 4095",
     "`[800, 2200.5]`"},
    {"two_numbers_with_a_unit",
     {.key = "k", .type = pulses, .unit = "raw"},
     "two numbers, raw",
     "",
     "none"},
    {"rate_of_change",
     {.key = "k", .type = slew, .fallback = "\"2000us/s\"", .least = 1, .most = 10000},
     "rate",
     "`\"1us/s\"` to `\"10000us/s\"`",
     "`\"2000us/s\"`"},
    {"scale_of_a_wire",
     {.key = "k", .type = scale, .fallback = "\"a\"", .choices = kWords},
     "text or table",
     "`\"a\"`, `\"b\"`, or `{ raw = [a, b], us = [c, d] }`",
     "`\"a\"`"},
    {"a_file", {.key = "k", .type = file}, "path of a file", "", "none"},
    {"a_key_file", {.key = "k", .type = key_file}, "path of a file", "", "none"},
    {"a_tree", {.key = "k", .type = tree}, "table", "", "none"},
};

class WordsOfAValue : public ::testing::TestWithParam<Row> {};

TEST_P(WordsOfAValue, TellTypeRangeAndDefault) {
    const KeyWords words = words_of({.setting = GetParam().setting});
    EXPECT_EQ(words.type, GetParam().type);
    EXPECT_EQ(words.range, GetParam().range);
    EXPECT_EQ(words.fallback, GetParam().fallback);
}

INSTANTIATE_TEST_SUITE_P(Each, WordsOfAValue, ::testing::ValuesIn(kRows),
                         [](const auto& row) { return std::string(row.param.name); });

/// `TYPE; RANGE`
std::string shape(KeyKind kind) {
    const KeyWords words = words_of({.setting = {.key = "k", .type = text}, .kind = kind});
    return fmt::format("{}; {}", words.type, words.range);
}

TEST(WordsOfAKey, TellItsShape) {
    EXPECT_EQ(shape(KeyKind::names), "name, or list of names; ");
    EXPECT_EQ(shape(KeyKind::presets), "table, us; channels 1 to 18, `other`; 500 to 2500 each");
    EXPECT_EQ(shape(KeyKind::weights), "table; channels 1 to 18; -10 to 10 each");
    EXPECT_EQ(shape(KeyKind::channels), "table; channels 1 to 18");
    EXPECT_EQ(shape(KeyKind::list), "list of tables; ");
    EXPECT_EQ(shape(KeyKind::table), "table; ");
    EXPECT_EQ(shape(KeyKind::named_tables), "tables with names; ");
    EXPECT_EQ(shape(KeyKind::texts), "table of texts; ");
    EXPECT_EQ(shape(KeyKind::line), "text or whole number; ");
}

TEST(WordsOfAKey, TellTheProtocolsOfItsWay) {
    const auto range = [](SettingScope way) {
        return words_of({.setting = {.key = "k", .type = text}, .kind = KeyKind::protocol}, way)
            .range;
    };
    for (const SettingScope way : {SettingScope::input, SettingScope::output}) {
        std::string expected;
        for (const std::string_view name : protocol_names(way)) {
            expected += fmt::format("{}`\"{}\"`", expected.empty() ? "" : ", ", name);
        }
        EXPECT_EQ(range(way), expected);
    }
    EXPECT_NE(range(SettingScope::input), range(SettingScope::output));
    EXPECT_EQ(words_of({.setting = {.key = "k"}, .kind = KeyKind::protocol}).type, "text");
}

TEST(WordsOfAKey, HaveASentenceAndAnExampleForEachWay) {
    const Key key{
        .setting = {
            .key = "k", .help = "Says `it`", .example = "\"in\"", .output_example = "\"out\""}};
    EXPECT_EQ(words_of(key).meaning, "Says `it`.");
    EXPECT_EQ(words_of(key).example, "k = \"in\"");
    EXPECT_EQ(words_of(key, SettingScope::input).example, "k = \"in\"");
    EXPECT_EQ(words_of(key, SettingScope::output).example, "k = \"out\"");
    const Key one{.setting = {.key = "k", .help = "Help", .example = "5"}};
    EXPECT_EQ(words_of(one, SettingScope::output).example, "k = 5");
}

TEST(HelpWithDefault, TellsWhatHoldsWhereTheKeyIsLeftOut) {
    EXPECT_EQ(help_with_default({.key = "k", .absent = "any processor", .help = "Processor"}),
              "Processor. Default: any processor");
    EXPECT_EQ(help_with_default({.key = "k", .help = "Processor"}), "Processor");
}

TEST(TextWithoutBackticks, HasAllElse) {
    EXPECT_EQ(without_backticks("`a` and `[b.c]`"), "a and [b.c]");
}

}  // namespace
}  // namespace tribus::test::words_test
