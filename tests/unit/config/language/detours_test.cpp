#include "config/language/detours.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

namespace tribus::test::detours_test {
namespace {

using Shown = std::vector<std::string>;

/// `FIRST LINE: REPLACEMENT`, then the column and the text, if it has them. A slash ends a line.
std::string shown(const Detour& detour) {
    return fmt::format("{}: {}{}{}{}", detour.first, fmt::join(detour.replacement, "/"),
                       detour.loses_text ? " (loses text)" : "",
                       detour.column ? fmt::format(" at {}", *detour.column) : "",
                       detour.text.empty() ? "" : " - " + detour.text);
}

Shown detours(const Lines& lines, std::size_t line) {
    Shown all;
    for (const Detour& detour : detours_around(lines, line)) {
        all.push_back(shown(detour));
    }
    return all;
}

/// Only those that leave lines out.
Shown losses(const Lines& lines, std::size_t line) {
    Shown all = detours(lines, line);
    std::erase_if(
        all, [](const std::string& one) { return one.find("(loses text)") == std::string::npos; });
    return all;
}

/// The first one, which changes the least.
std::string best(const Lines& lines, std::size_t line = 0) {
    return detours(lines, line).front();
}

/// The detour that closes that line.
Shown closed(std::size_t line, const std::string& text) {
    Shown all;
    for (const std::string closer : {"\"", "'", "]", "}", "]]", "\"]", "\" }"}) {
        all.push_back(fmt::format("{}: {}{} - this line ends too early; a closing {} is missing",
                                  line, text, closer, closer));
    }
    return all;
}

Shown joined(const std::vector<Shown>& parts) {
    Shown all;
    for (const Shown& part : parts) {
        all.insert(all.end(), part.begin(), part.end());
    }
    return all;
}

TEST(DetoursAroundALine, CloseOrLeaveOutTheOnlyOne) {
    EXPECT_EQ(detours({"  x = (  "}, 0), joined({closed(0, "x = ("), {"0:  (loses text)"}}));
}

TEST(DetoursAroundALine, CloseOrLeaveOutTheStatementBeforeToo) {
    EXPECT_EQ(detours({"a = 1", " b = [", "  1,", "  2", " \t", "(", "c = 3"}, 5),
              joined({closed(5, "("),
                      closed(3, "2"),
                      closed(1, "b = ["),
                      {"5:  (loses text)", "1:  (loses text)", "1: // (loses text)",
                       "1: //// (loses text)"}}));
}

TEST(DetoursAroundALine, ReachBackToTheFirstLine) {
    EXPECT_EQ(losses({"a = [", "  1", "("}, 2), (Shown{"2:  (loses text)", "0:  (loses text)",
                                                       "0: / (loses text)", "0: // (loses text)"}));
    EXPECT_EQ(losses({"  1", "("}, 1), (Shown{"1:  (loses text)", "0:  (loses text)",
                                              "0:  (loses text)", "0: / (loses text)"}));
    EXPECT_EQ(losses({"", "", "("}, 2), (Shown{"2:  (loses text)", "0:  (loses text)",
                                               "0:  (loses text)", "0: // (loses text)"}));
}

TEST(DetoursAroundALine, TakeAHeaderOrAKeyForTheBeginOfAStatement) {
    for (const std::string begin : {"[b]", " [[b]]", "a_b-9 = 1", "a b = [", "= 1"}) {
        EXPECT_EQ(losses({"x = [", begin, "1", "("}, 3)[1].substr(0, 2), "1:") << begin;
    }
    for (const std::string other : {"\"b\" = 1", "{ c = 1", "b", "1, 2", "a.b = 1"}) {
        EXPECT_EQ(losses({"x = [", other, "1", "("}, 3)[1].substr(0, 2), "0:") << other;
    }
}

TEST(DetoursAroundALine, LeaveATableInThePlaceOfAHeader) {
    EXPECT_EQ(losses({" [a b]"}, 0), Shown{"0: [\"lost table of line 1\"] (loses text)"});
    EXPECT_EQ(losses({"x = 1", "[a]", "(", ""}, 2),
              (Shown{"2:  (loses text)", "1: [\"lost table of line 2\"] (loses text)",
                     "1: [\"lost table of line 2\"] (loses text)",
                     "1: [\"lost table of line 2\"]/ (loses text)"}));
}

TEST(DetoursAroundALine, LeaveOutTheNearestLineBeforeWithThreeQuotes) {
    for (const std::string quotes : {"\"\"\"", "'''"}) {
        const std::string begin = "a = " + quotes;
        EXPECT_EQ(losses({begin, "b", "c = 1", "("}, 3).back(), "0:  (loses text)");
        EXPECT_EQ(losses({begin, begin, "c = 1", "("}, 3).back(), "1:  (loses text)");
        EXPECT_EQ(losses({begin, begin, "c = 1", "("}, 3).size(), 5U);
        EXPECT_EQ(losses({"c = 1", begin}, 1).back(), "1:  (loses text)");
        EXPECT_EQ(losses({"c = 1", "(", begin}, 1).size(), 4U) << "behind the line";
    }
}

TEST(DetoursAroundALine, PutAValueIntoQuotesFirst) {
    EXPECT_EQ(best({"  a b =  b/c.d:e,f+g h_i-9 # x"}),
              "0: a b = \"b/c.d:e,f+g h_i-9\" - b/c.d:e,f+g h_i-9 is not a valid value; put text "
              "and durations in quotes: a b = \"b/c.d:e,f+g h_i-9\"");
    EXPECT_EQ(best({"a = ibus"}),
              "0: a = \"ibus\" - ibus is not a valid value; put text and durations in quotes: a = "
              "\"ibus\"");
}

TEST(DetoursAroundALine, TakeNoOtherValueForText) {
    for (const std::string line :
         {"a", "a =", "a = # b", "[a = b", "a = b;", "a = b = c", "a = \"b", "a = [b", "a = (b)"}) {
        EXPECT_EQ(detours({line}, 0),
                  joined({closed(0, line),
                          {line.starts_with("[") ? "0: [\"lost table of line 1\"] (loses text)"
                                                 : "0:  (loses text)"}}))
            << line;
    }
}

TEST(DetoursAroundALine, TellWhatIsTrueAndFalse) {
    for (const std::string word : {"true", "false", "yes", "no", "on", "off", "True", "flase"}) {
        EXPECT_EQ(best({"a = " + word}),
                  "0: a = \"" + word + "\" - " + word +
                      " is not a valid value; allowed: true or false, or text in quotes");
    }
}

TEST(DetoursAroundALine, BeginWithItsCorrections) {
    EXPECT_EQ(best({"\u00e4 = [01, 02]"}),
              "0: \u00e4 = [1, 2] at 6 - 01 is not a valid value: a number does not begin with 0; "
              "write 1");
}

TEST(DetoursAroundALine, JoinATableOfSeveralLines) {
    EXPECT_EQ(best({"[t.u]", "\u00e4 = {", "  b = [1,", "2], c = 01, # d", "}", "x = 1"}, 1),
              "1: \u00e4 = { b = [ 1, 2 ], c = 1 }/// at 5 - a table between { and } must end in "
              "the line in which it begins; write \u00e4 = { b = [ 1, 2 ], c = 1 }, or a table "
              "[t.u.\u00e4]");
    EXPECT_EQ(best({" [ t ] # x", "a = { b = {", "c = 1 } }"}, 1),
              "1: a = { b = { c = 1 } }/ at 5 - a table between { and } must end in the line in "
              "which it begins; write a = { b = { c = 1 } }, or a table [ t .a]");
}

TEST(DetoursAroundALine, NameNoTableOfItsOwnWhereThereCannotBeOne) {
    const std::string joined =
        "a = { b = 1 }/ at 5 - a table between { and } must end in the line in which it begins; "
        "write a = { b = 1 }";
    for (const std::string above : {"x = 1", "[[t]]", "[\"lost table of line 1\"]"}) {
        EXPECT_EQ(best({above, "a = {", "b = 1 }"}, 1), "1: " + joined) << above;
    }
    EXPECT_EQ(best({"a = {", "b = 1 }"}), "0: " + joined);
    EXPECT_EQ(best({"[t]", "a = [{ b = 1 }, {", "c = 2 }]"}, 1),
              "1: a = [ { b = 1 }, { c = 2 } ]/ at 17 - a table between { and } must end in the "
              "line in which it begins; write a = [ { b = 1 }, { c = 2 } ]");
    EXPECT_EQ(best({"[t]", "a { b = 1,", "c = 2 }"}, 1),
              "1: a { b = 1, c = 2 }/ at 3 - a table between { and } must end in the line in which "
              "it begins; write a { b = 1, c = 2 }");
    EXPECT_EQ(best({"[t]", "{", "}"}, 1),
              "1: { }/ at 1 - a table between { and } must end in the line in which it begins; "
              "write { }");
}

TEST(DetoursAroundALine, DoNotShowALongTable) {
    const auto text = [](const std::string& key) {
        return detours_around({"[t]", "a = { b = 1,", key + " = 2 }"}, 1).front().text;
    };
    const std::string begin =
        "a table between { and } must end in the line in which it begins; write ";
    const std::string hundred(81, 'x');
    EXPECT_EQ(text(hundred), begin + "a = { b = 1, " + hundred + " = 2 }, or a table [t.a]");
    EXPECT_EQ(text(hundred + "x"), begin + "it in one line, or a table [t.a]");
}

TEST(DetoursAroundALine, JoinAtMost64Lines) {
    Lines lines{"a = {"};
    lines.resize(63, "");
    lines.push_back("b = 1 }");
    lines.emplace_back("c = 1");
    EXPECT_EQ(detours_around(lines, 0).front().replacement.size(), 64U);
    lines.insert(lines.begin() + 1, "");
    EXPECT_EQ(detours_around(lines, 0).front().replacement.size(), 1U);
}

TEST(DetoursAroundALine, JoinNoTableThatDoesNotEndOrIsNone) {
    for (const Lines& lines :
         {Lines{"a = {", "b = ("}, Lines{"a = }", "b = ("}, Lines{"a = { b = ( }", "c = 1"},
          Lines{"a = \"{\" (", "b = \"}\""}}) {
        EXPECT_EQ(best(lines), closed(0, lines[0]).front());
    }
}

TEST(Trimmed, IsWithoutBlanksTabsAndReturnsAtBothEnds) {
    EXPECT_EQ(trimmed(" \t\ra b\r \t"), "a b");
    EXPECT_EQ(trimmed("a"), "a");
    EXPECT_EQ(trimmed(" \r"), "");
    EXPECT_EQ(trimmed(""), "");
    EXPECT_EQ(trimmed("\va\n"), "\va\n");
}

TEST(Header, IsALineThatBeginsWithABracket) {
    EXPECT_TRUE(is_header(" [a]"));
    EXPECT_TRUE(is_header("[["));
    EXPECT_FALSE(is_header("a[b]"));
    EXPECT_FALSE(is_header(""));
}

TEST(LettersOfAWord, AreLettersDigitsUnderscoreAndMinus) {
    for (const char c : std::string("azAZ09_-")) {
        EXPECT_TRUE(is_word(c)) << c;
    }
    for (const char c : std::string(".+: =\xE4")) {
        EXPECT_FALSE(is_word(c)) << c;
    }
}

}  // namespace
}  // namespace tribus::test::detours_test
