#include "config/language/corrections.h"

#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace tribus::test::corrections_test {
namespace {

using Lines = std::vector<std::string>;

/// `OFFSET:TEXT` for each part, those in quotes with `q` before the colon.
std::string parts(std::string_view line) {
    std::string shown;
    for (const LinePart& part : parts_of_line(line)) {
        shown += fmt::format("{}{}{}:{}", shown.empty() ? "" : "  ", part.at,
                             part.in_quotes ? "q" : "", part.text);
    }
    return shown;
}

struct Cut {
    std::string_view name;
    std::string_view line;
    std::string_view parts;
};

std::ostream& operator<<(std::ostream& out, const Cut& cut) {
    return out << cut.name;
}

constexpr Cut kCuts[]{
    {"nothing", "", ""},
    {"blanks", " \t ", ""},
    {"a_number", "a = 12", "0:a  2:=  4:12"},
    {"no_blanks", "a=1", "0:a  1:=  2:1"},
    {"tabs", "\ta\t=\t1", "1:a  3:=  5:1"},
    {"all_letters_of_a_word", "a_B-9.+: = 1", "0:a_B-9.+:  9:=  11:1"},
    {"letters_beyond_ascii", "\u00e4b \u00c0", "0:\u00e4b  4:\u00c0"},
    {"marks", "{a=[1],}", "0:{  1:a  2:=  3:[  4:1  5:]  6:,  7:}"},
    {"a_comment", "a = 1 # b = 2", "0:a  2:=  4:1"},
    {"a_hash_in_quotes", "a = \"b # c\" # d", "0:a  2:=  4q:\"b # c\""},
    {"two_texts", "\"a\" 'b'", "0q:\"a\"  4q:'b'"},
    {"texts_without_a_blank", "a\"b\"'c'd", "0:a  1q:\"b\"  4q:'c'  7:d"},
    {"empty_texts", "\"\" ''", "0q:\"\"  3q:''"},
    {"a_quote_of_the_other_kind", "\"it's\" '\"'", "0q:\"it's\"  7q:'\"'"},
    {"an_escaped_quote", R"("a\"b" c)", R"(0q:"a\"b"  7:c)"},
    {"an_escaped_backslash", R"("a\\" "b")", R"(0q:"a\\"  6q:"b")"},
    {"an_escape_at_the_start", R"("\"" a)", R"(0q:"\""  5:a)"},
    {"two_escapes_in_a_row", R"("\\\"" a)", R"(0q:"\\\""  7:a)"},
    {"a_backslash_between_single_quotes", R"('a\' b)", R"(0q:'a\'  5:b)"},
    {"a_text_without_an_end", "a = \"b # c", "0:a  2:=  4q:\"b # c"},
    {"a_text_whose_end_is_escaped", R"(a = "b\" )", R"(0:a  2:=  4q:"b\" )"},
    {"a_single_quote_without_an_end", "a = 'b c", "0:a  2:=  4q:'b c"},
    {"a_quote_alone", "\"", "0q:\""},
    {"a_backslash_behind_a_quote", R"("\)", R"(0q:"\)"},
    {"the_end_of_a_line_of_windows", "a = 1\r", "0:a  2:=  4:1"},
    {"several_returns_at_the_end", "a\r\r", "0:a"},
    {"a_return_in_the_middle", "a\rb", "0:a  1:\r  2:b"},
};

class PartsOfALine : public ::testing::TestWithParam<Cut> {};

TEST_P(PartsOfALine, AreTextsWordsAndMarks) {
    EXPECT_EQ(parts(GetParam().line), GetParam().parts);
}

INSTANTIATE_TEST_SUITE_P(Each, PartsOfALine, ::testing::ValuesIn(kCuts),
                         [](const auto& cut) { return std::string(cut.param.name); });

Lines messages(std::string_view line) {
    Lines told;
    for (const Correction& correction : corrections_in(line)) {
        told.push_back(fmt::format("{}: {}", correction.at, correction.message));
    }
    return told;
}

std::string repaired(std::string_view line) {
    return corrected(line, corrections_in(line));
}

TEST(CorrectionsOfALine, AreNoneWhereItIsRight) {
    for (const std::string_view line : {
             "",
             "a = 1",
             "a = 0.5",
             "a = [1, 5]",
             "a = { b = 1, c = 2 }",
             "05 = 1",
             "[05]",
             "  [a.05]",
             "a = \"05\"",
             "a = '05'",
             "a = 1 # 05",
             "a = \"x",
         }) {
        EXPECT_EQ(messages(line), Lines{}) << line;
    }
}

TEST(CorrectionsOfALine, AreTheNumbersThatTomlRefuses) {
    EXPECT_EQ(messages("a = [05, .5]"),
              (Lines{"5: 05 is not a valid value: a number does not begin with 0; write 5",
                     "9: .5 is not a valid value: a decimal point has digits on both sides; write "
                     "0.5"}));
    EXPECT_EQ(repaired("a = [05, .5] # 05"), "a = [5, 0.5] # 05");
}

TEST(CorrectionsOfALine, AreNoKeys) {
    EXPECT_EQ(repaired("a = { 05 = 06, 07= 08 }"), "a = { 05 = 6, 07= 8 }");
}

TEST(CorrectionsOfALine, AreACommaBeforeTheEndOfATable) {
    EXPECT_EQ(messages("a = { b = 1 , }"),
              Lines{"12: there is a comma before }, with nothing behind it; leave it out"});
    EXPECT_EQ(repaired("a = { b = 1 , }"), "a = { b = 1  }");
    EXPECT_EQ(repaired("a = [{ b = 01, }, { c = .5,}]"), "a = [{ b = 1 }, { c = 0.5}]");
    EXPECT_EQ(messages("a = [1, ]"), Lines{});
    EXPECT_EQ(messages("a = { b = \",\" }"), Lines{});
}

TEST(CorrectionsOfALine, AreADecimalComma) {
    EXPECT_EQ(messages("a = 0 , 50 # c"),
              Lines{"4: 0,50 is not a valid value: a number has a decimal point; write 0.50"});
    EXPECT_EQ(repaired("a = 0 , 50 # c"), "a = 0.50 # c");
    EXPECT_EQ(repaired("  b=-12,5"), "  b=-12.5");
}

TEST(CorrectionsOfALine, AreNoDecimalCommaWhereAnythingElseStands) {
    for (const std::string_view line : {"a = 1,5 7", "a = 1,", "a , 1,5", "a = 1 = 5", "a = x,5",
                                        "a = 1,x", "a = -,5", "a = 1,-", "a = ,,5", "a = 1,5,6"}) {
        EXPECT_EQ(messages(line), Lines{}) << line;
    }
}

TEST(CorrectionsOfALine, DoNotTouchTheEscapesOfToml) {
    for (const std::string_view line :
         {R"(a = "\b\t\n\f\r\"\\")", R"(a = "\\d")", R"(a = "\u00e4")", R"(a = "\u00e4x")",
          R"(a = "\U0001F60a")", R"(a = "\U0001F60ax")", R"(a = "x\u00E4\u00e4")",
          R"(a = 'C:\dir')", R"(a = "C:\dir)", R"(a = 'C:\dir")", R"(a = "it's C:\\dir")"}) {
        EXPECT_EQ(messages(line), Lines{}) << line;
    }
}

TEST(CorrectionsOfALine, DoubleBackslashesThatAreNoEscapes) {
    for (const auto& [line, expected] : std::vector<std::pair<std::string, std::string>>{
             {R"(a = "\d")", R"(a = "\\d")"},
             {R"(a = "x\")", R"(a = "x\\")"},
             {R"(a = "\")", R"(a = "\\")"},
             {R"(a = "n\n\d\\")", R"(a = "n\\n\\d\\\\")"},
             {R"(a = "\u00eg")", R"(a = "\\u00eg")"},
             {R"(a = "\ug0e4")", R"(a = "\\ug0e4")"},
             {R"(a = "\u00e")", R"(a = "\\u00e")"},
             {R"(a = "\u")", R"(a = "\\u")"},
             {R"(a = "\U0001F60")", R"(a = "\\U0001F60")"},
             {R"(a = "\U0001F60g")", R"(a = "\\U0001F60g")"},
             {R"(a = "\x00" # b)", R"(a = "\\x00" # b)"},
             {R"(a = ["\d", "b", "\e"])", R"(a = ["\\d", "b", "\\e"])"},
         }) {
        EXPECT_EQ(repaired(line), expected);
    }
}

TEST(CorrectionsOfALine, ShowBackslashesBothWays) {
    EXPECT_EQ(messages(R"(a = "C:\dir")"),
              Lines{R"(4: "C:\dir" has a backslash, which begins an escape between "; write )"
                    R"('C:\dir' or "C:\\dir")"});
    EXPECT_EQ(messages(R"(a = "it's C:\dir")"),
              Lines{R"(4: "it's C:\dir" has a backslash, which begins an escape between "; write )"
                    R"("it's C:\\dir")"});
}

TEST(CorrectionsOfALine, DoNotShowATextOfMoreThan60Bytes) {
    const std::string sixty = R"(C:\d)" + std::string(56, 'x');
    EXPECT_EQ(
        messages("a = \"" + sixty + "\""),
        Lines{"4: \"" + sixty + "\" has a backslash, which begins an escape between \"; write '" +
              sixty + "' or \"C:\\\\d" + std::string(56, 'x') + "\""});
    EXPECT_EQ(messages("a = \"" + sixty + "x\""),
              Lines{"4: this text has a backslash, which begins an escape between \"; write '...' "
                    "or each backslash twice"});
    EXPECT_EQ(messages("a = \"" + sixty + "'\""),
              Lines{"4: this text has a backslash, which begins an escape between \"; write each "
                    "backslash twice"});
}

}  // namespace
}  // namespace tribus::test::corrections_test
