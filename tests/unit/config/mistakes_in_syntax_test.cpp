#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

namespace tribus::test::mistakes_in_syntax_test {
namespace {

class MistakeInSyntax : public ::testing::TestWithParam<Spoilt> {};

TEST_P(MistakeInSyntax, IsReportedWithItsPlaceAndWhatIsAllowed) {
    const Spoilt& spoilt = GetParam();
    const auto mistakes = mistakes_in(main_job_with(spoilt.line, spoilt.replacement));
    EXPECT_EQ(mistakes, std::vector<std::string>{std::string(spoilt.expected)});
}

constexpr Spoilt kMistakes[]{
    {"text_without_quotes", 2, "protocol = ibus",
     R"(t.toml:2:13: ibus is not a valid value; put text and durations in quotes: protocol = )"
     R"("ibus")"},
    {"path_without_quotes", 3, "device = /dev/ttyA # the first",
     R"(t.toml:3:10: /dev/ttyA is not a valid value; put text and durations in quotes: device = )"
     R"("/dev/ttyA")"},
    {"duration_without_quotes", 3,
     R"(device = "/dev/ttyA"
timeout = 100ms)",
     R"(t.toml:4:14: 100ms is not a valid value; put text and durations in quotes: timeout = )"
     R"("100ms")"},
    {"quote_not_closed", 3, R"(device = "/dev/ttyA)",
     R"(t.toml:3:20: this line ends too early; a closing " is missing)"},
    {"header_not_closed", 1, "[input.receiver",
     R"(t.toml:1:16: this line ends too early; a closing ] is missing)"},
    {"letter_beyond_ascii_without_quotes", 3, "device = \"/dev/ttyA\" \u00e4",
     "t.toml:3:22: not valid TOML: Error while parsing key-value pair: expected a comment or "
     "whitespace, saw '\u00e4'"},
    {"letter_of_another_script_without_quotes", 3, "device = \"/dev/ttyA\"\n\u0492 = 1",
     "t.toml:4:1: not valid TOML: Error while parsing root table: expected keys, tables, "
     "whitespace or comments, saw '\u0492'"},
    {"list_not_closed", 8, R"(from = ["receiver")",
     R"(t.toml:8:19: this line ends too early; a closing ] is missing)"},
    {"inline_table_not_closed", 10,
     R"([pipeline.main.channels]
1 = { from = 2, reverse = true)",
     R"(t.toml:11:31: this line ends too early; a closing } is missing)"},
    {"key_given_twice", 3,
     R"(device = "/dev/ttyA"
device = "/dev/ttyC")",
     R"(t.toml:4:1: this key or table was already given further up; give each once)"},
    {"table_given_twice", 10,
     R"([output.servos]
device = "/dev/ttyC")",
     R"(t.toml:10:1: this key or table was already given further up; give each once)"},
    {"no_equals_sign", 3, R"(device "/dev/ttyA")",
     R"(t.toml:3:8: not valid TOML: Error while parsing key-value pair: expected '=', )"
     R"(saw '"')"},
    {"no_value", 3, "device =",
     R"(t.toml:3:9: not valid TOML: Error while parsing key-value pair: expected value, )"
     R"(saw '\n')"},
    {"yes_for_true", 6,
     R"(device = "/dev/ttyB"
force = yes)",
     R"(t.toml:7:9: yes is not a valid value; allowed: true or false, or text in quotes)"},
    {"escape_that_toml_lacks", 3, R"(device = "/dev/tty\xff")",
     R"(t.toml:3:10: "/dev/tty\xff" has a backslash, which begins an escape between "; write )"
     R"('/dev/tty\xff' or "/dev/tty\\xff")"},
    {"words_after_a_value", 3, R"(device = "/dev/ttyA" "/dev/ttyC")",
     R"(t.toml:3:22: not valid TOML: Error while parsing key-value pair: expected a )"
     R"(comment or whitespace, saw '"')"},
};

INSTANTIATE_TEST_SUITE_P(Mistakes, MistakeInSyntax, ::testing::ValuesIn(kMistakes),
                         [](const auto& mistake) { return std::string(mistake.param.name); });

}  // namespace
}  // namespace tribus::test::mistakes_in_syntax_test
