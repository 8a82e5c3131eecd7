#include "core/quotes.h"

#include <array>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace tribus::quotes_test {
namespace {

TEST(Quotes, StandAroundTheText) {
    EXPECT_EQ(in_quotes("can0"), "\"can0\"");
    EXPECT_EQ(in_quotes(""), "\"\"");
}

TEST(Quotes, QuotesAndBackslashesInsideAreEscaped) {
    EXPECT_EQ(in_quotes(R"(a"b\c)"), R"("a\"b\\c")");
}

TEST(Quotes, ControlCharactersDoNotBreakTheLine) {
    EXPECT_EQ(in_quotes("a\nb\x1b\x7f"), R"("a\u000ab\u001b\u007f")");
    EXPECT_EQ(in_quotes(std::string_view("\0", 1)), R"("\u0000")");
}

TEST(Quotes, Utf8StaysAsItIs) {
    EXPECT_EQ(in_quotes("\u00B5s"), "\"\u00B5s\"");
}

TEST(Quotes, OnlyTextLongerThanTheMostIsCut) {
    EXPECT_EQ(in_quotes("abcd", 4), "\"abcd\"");
    EXPECT_EQ(in_quotes("abcde", 4), "\"abcd\"...");
}

TEST(Quotes, TheCutIsNotInTheMiddleOfACharacter) {
    EXPECT_EQ(in_quotes("ab\u00B5s", 3), "\"ab\"...");
    EXPECT_EQ(in_quotes("ab\u00B5s", 4), "\"ab\u00B5\"...");
}

TEST(Quotes, NamesStandInARow) {
    constexpr std::array<std::string_view, 2> kNames{"a", "b"};
    EXPECT_EQ(in_quotes_all(kNames), R"("a", "b")");
    EXPECT_EQ(in_quotes_all({}), "");
}

}  // namespace
}  // namespace tribus::quotes_test
