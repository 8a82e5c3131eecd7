#include "config/language/places.h"

#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace tribus::test::places_test {
namespace {

std::string behind(std::string_view text) {
    TextPlace place;
    place.pass(text);
    return fmt::format("{}:{}", place.where().line, place.where().column);
}

TEST(TextPlace, CountsLinesAndCharacters) {
    EXPECT_EQ(behind(""), "1:1");
    EXPECT_EQ(behind("ab\t"), "1:4");
    EXPECT_EQ(behind("ab\n"), "2:1");
    EXPECT_EQ(behind("a\n\nbc"), "3:3");
    EXPECT_EQ(behind("a\r"), "1:3");
}

TEST(TextPlace, TakesACharacterBeyondAsciiForOneColumn) {
    EXPECT_EQ(behind("\u00e4"), "1:2");
    EXPECT_EQ(behind("\u20ac\u00bf"), "1:3");
    EXPECT_EQ(behind("\U0001F600x"), "1:3");
}

std::string further(const std::vector<Location>& places) {
    RepeatedMistake mistake;
    for (const Location where : places) {
        mistake.add(where);
    }
    return mistake.further_lines();
}

TEST(RepeatedMistake, NamesItsFurtherLines) {
    EXPECT_EQ(further({}), "");
    EXPECT_EQ(further({{3, 1}}), "");
    EXPECT_EQ(further({{3, 1}, {3, 9}}), "");
    EXPECT_EQ(further({{3, 1}, {5, 1}, {5, 2}}), " (also in line 5)");
    EXPECT_EQ(further({{3, 1}, {5, 1}, {9, 2}}), " (also in lines 5, 9)");
}

TEST(RepeatedMistake, NamesFiveLinesAtMost) {
    std::vector<Location> places{{1, 1}, {2, 1}, {3, 1}, {4, 1}, {5, 1}, {6, 1}};
    EXPECT_EQ(further(places), " (also in lines 2, 3, 4, 5, 6)");
    places.push_back({7, 1});
    EXPECT_EQ(further(places), " (also in lines 2, 3, 4, 5, 6 and 1 more)");
}

TEST(RepeatedMistake, StandsWhereItWasFirst) {
    RepeatedMistake mistake;
    EXPECT_TRUE(mistake.empty());
    mistake.add({3, 7});
    mistake.add({4, 1});
    EXPECT_FALSE(mistake.empty());
    EXPECT_EQ(mistake.first().line, 3U);
    EXPECT_EQ(mistake.first().column, 7U);
}

}  // namespace
}  // namespace tribus::test::places_test
