#include "config/language/mistakes.h"

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::test::mistakes_test {
namespace {

using Texts = std::vector<std::string>;

Texts lines_of(const Mistakes& mistakes) {
    Texts lines;
    for (const Mistake& mistake : mistakes.sorted()) {
        lines.push_back(format_mistake(mistake));
    }
    return lines;
}

/// As many texts as there may be.
Mistakes full() {
    Mistakes mistakes("f");
    for (std::size_t i = 0; i < Mistakes::kMostTexts; ++i) {
        mistakes.add_out_of_reach({1, 1}, "x");
    }
    return mistakes;
}

TEST(FormatMistake, BeginsWithTheFileAndThePlaceIfItHasOne) {
    EXPECT_EQ(format_mistake({"a.toml", {3, 10}, "wrong"}), "a.toml:3:10: wrong");
    EXPECT_EQ(format_mistake({"a.toml", {1, 1}, "wrong"}), "a.toml:1:1: wrong");
    EXPECT_EQ(format_mistake({"a.toml", {}, "wrong"}), "a.toml: wrong");
}

TEST(CollectedMistakes, AreSortedByLineAndColumnAndElseInTheirOrder) {
    Mistakes mistakes("f");
    EXPECT_TRUE(mistakes.empty());
    mistakes.add({2, 5}, "a");
    mistakes.add({2, 4}, "b");
    mistakes.add({1, 9}, "c");
    mistakes.add({2, 4}, "d");
    EXPECT_FALSE(mistakes.empty());
    EXPECT_EQ(lines_of(mistakes), (Texts{"f:1:9: c", "f:2:4: b", "f:2:4: d", "f:2:5: a"}));
    EXPECT_EQ(mistakes.file(), "f");
}

TEST(CollectedMistakes, KnowTheirLines) {
    Mistakes mistakes("f");
    mistakes.add({2, 5}, "a");
    mistakes.add({4, 5}, "b");
    EXPECT_TRUE(mistakes.on_line(2));
    EXPECT_TRUE(mistakes.on_line(4));
    EXPECT_FALSE(mistakes.on_line(3));
}

TEST(CollectedMistakes, AreThoseOfOthersToo) {
    Mistakes mistakes("f");
    mistakes.add({2, 5}, "a");
    Mistakes others("g");
    others.add({1, 1}, "b");
    mistakes.add(others);
    EXPECT_EQ(lines_of(mistakes), (Texts{"g:1:1: b", "f:2:5: a"}));
}

TEST(CollectedMistakes, CanLeaveOutTheLinesOfOthers) {
    Mistakes mistakes("f");
    mistakes.add({2, 5}, "a");
    mistakes.add({3, 5}, "b");
    mistakes.count();
    Mistakes others("f");
    others.add({2, 1}, "c");
    EXPECT_EQ(lines_of(mistakes.without_lines_of(others)), (Texts{"f:3:5: b", "f: and 1 more"}));
}

TEST(CollectedMistakes, AreCountedWhereThereAreAHundredTexts) {
    Mistakes mistakes = full();
    EXPECT_TRUE(mistakes.full());
    EXPECT_EQ(mistakes.sorted().size(), 100U);
    mistakes.add({1, 1}, "y");
    mistakes.add(full());
    EXPECT_EQ(mistakes.sorted().size(), 101U);
    EXPECT_EQ(lines_of(mistakes).back(), "f: and 101 more");
    Mistakes first("f");
    first.add({1, 1}, "z");
    EXPECT_FALSE(first.full());
    first.add(mistakes);
    EXPECT_EQ(lines_of(first).back(), "f: and 102 more");
}

TEST(CollectedMistakes, AreCountedInThousands) {
    Mistakes mistakes("f");
    std::size_t count = 0;
    for (const auto& [number, text] :
         std::vector<std::pair<std::size_t, std::string>>{{1, "1"},
                                                          {999, "999"},
                                                          {1000, "1,000"},
                                                          {99'999, "99,999"},
                                                          {100'000, "100,000"},
                                                          {999'999, "999,999"},
                                                          {1'000'000, "1,000,000"}}) {
        for (; count < number; ++count) {
            mistakes.count();
        }
        EXPECT_EQ(lines_of(mistakes), Texts{"f: and " + text + " more"});
    }
}

TEST(CollectedMistakes, MayBeTemporaryIfAllAreOutOfReach) {
    Mistakes mistakes("f");
    EXPECT_FALSE(may_be_temporary(mistakes.sorted())) << "there is none";
    mistakes.add_out_of_reach({1, 1}, "a");
    EXPECT_TRUE(may_be_temporary(mistakes.sorted()));
    mistakes.add({1, 1}, "b");
    EXPECT_FALSE(may_be_temporary(mistakes.sorted()));
}

TEST(CollectedMistakes, WithoutATextDecideTooWhetherAllMayBeTemporary) {
    Mistakes unreachable = full();
    unreachable.add_out_of_reach({1, 1}, "a");
    EXPECT_TRUE(may_be_temporary(unreachable.sorted()));
    Mistakes both = unreachable;
    both.add({1, 1}, "b");
    both.add_out_of_reach({1, 1}, "c");
    EXPECT_FALSE(may_be_temporary(both.sorted()));
    Mistakes sum("f");
    sum.add(unreachable);
    EXPECT_TRUE(may_be_temporary(sum.sorted()));
    sum.add(both);
    EXPECT_FALSE(may_be_temporary(sum.sorted()));
    Mistakes counted = full();
    counted.count();
    EXPECT_FALSE(may_be_temporary(counted.sorted()));
    EXPECT_FALSE(may_be_temporary(both.without_lines_of(Mistakes("f")).sorted()));
    EXPECT_TRUE(may_be_temporary(unreachable.without_lines_of(Mistakes("f")).sorted()));
}

TEST(Suggestion, NamesTheNearestWordAndAllThatAreAllowed) {
    constexpr std::array<std::string_view, 2> kAllowed{"from", "to"};
    EXPECT_EQ(suggestion("form", kAllowed), R"(did you mean "from"? Allowed: "from", "to")");
    EXPECT_EQ(suggestion("other", kAllowed), R"(allowed: "from", "to")");
    EXPECT_EQ(suggestion("form", {}), "there is none");
}

}  // namespace
}  // namespace tribus::test::mistakes_test
