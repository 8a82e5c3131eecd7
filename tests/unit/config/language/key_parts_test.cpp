#include "config/language/key_parts.h"

#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace tribus::test::key_parts_test {
namespace {

std::string dots(std::size_t count) {
    std::string text;
    for (std::size_t i = 0; i < count; ++i) {
        text += "a.";
    }
    return text;
}

/// `LINE:COLUMN`; empty if no key has too many parts.
std::string found(const std::string& text) {
    const auto where = find_key_of_too_many_parts(text);
    return where ? fmt::format("{}:{}", where->line, where->column) : "";
}

TEST(KeyOfTooManyParts, IsOneOfMoreThanSixteen) {
    EXPECT_EQ(found(dots(15) + "a"), "");
    EXPECT_EQ(found(dots(16) + "a"), "1:33");
    EXPECT_EQ(found("x = 1\n [" + dots(16) + "a]"), "2:35");
    EXPECT_EQ(found(""), "");
}

TEST(KeyOfTooManyParts, DoesNotGoOnBehindWhatIsBetweenKeys) {
    for (const char between : std::string("\n=,[]{}")) {
        EXPECT_EQ(found(dots(10) + between + dots(10)), "") << between;
        EXPECT_EQ(found(dots(10) + between + dots(15)), "") << between;
        EXPECT_NE(found(dots(10) + between + dots(16)), "") << between;
    }
    for (const char within : std::string(" \t-+:\r")) {
        EXPECT_NE(found(dots(10) + within + dots(6)), "") << within;
    }
}

TEST(KeyOfTooManyParts, IsNotInAComment) {
    EXPECT_EQ(found("# " + dots(20)), "");
    EXPECT_EQ(found(dots(10) + "# " + dots(20) + "\n" + dots(10)), "");
    EXPECT_EQ(found("# \"\n" + dots(16)), "2:33");
}

TEST(KeyOfTooManyParts, IsNotInAText) {
    for (const std::string& text :
         {"\"" + dots(20) + "\"", "'" + dots(20) + "'",
          "\"\"\"" + dots(20) + "\n" + dots(20) + "\"\"\"",
          "'''" + dots(20) + "\n'" + dots(20) + "'''", "\"\\\"" + dots(20) + "\"",
          "\"\"\"\\\"\"\"" + dots(20) + "\"\"\""}) {
        EXPECT_EQ(found("x = " + text), "") << text;
        EXPECT_EQ(found("x = " + text + dots(15)), "") << text;
        EXPECT_NE(found("x = " + text + dots(16)), "") << text;
    }
}

TEST(KeyOfTooManyParts, IsFoundBehindTheEndOfAText) {
    EXPECT_EQ(found("\"\\\\\"" + dots(16)), "1:37");
    EXPECT_EQ(found("'\\'" + dots(16)), "1:36");
    EXPECT_EQ(found("\"\"" + dots(16)), "1:35");
    EXPECT_EQ(found("''" + dots(16)), "1:35");
    EXPECT_EQ(found("\"\"\"\n\"\"\"" + dots(16)), "2:36");
    EXPECT_EQ(found("'''\\'''" + dots(16)), "1:40");
    EXPECT_EQ(found("\"\u00e4\"" + dots(16)), "1:36");
}

TEST(KeyOfTooManyParts, IsFoundInTheLineBehindATextThatDoesNotEnd) {
    EXPECT_EQ(found("\"" + dots(20) + "\n" + dots(16)), "2:33");
    EXPECT_EQ(found("'" + dots(20) + "\n" + dots(16)), "2:33");
    EXPECT_EQ(found(dots(10) + "\"x\n" + dots(10)), "");
    EXPECT_EQ(found("\"x\\"), "");
    EXPECT_EQ(found("\"\"\"" + dots(20)), "");
    EXPECT_EQ(found("'''" + dots(20) + "''"), "");
}

}  // namespace
}  // namespace tribus::test::key_parts_test
