#include "config/language/nearest.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace tribus::test::nearest_test {
namespace {

TEST(SlipsBetween, CountsLettersTooManyTooFewWrongAndSwapped) {
    EXPECT_EQ(edit_distance("device", "device"), 0U);
    EXPECT_EQ(edit_distance("device", "devicee"), 1U);
    EXPECT_EQ(edit_distance("device", "devce"), 1U);
    EXPECT_EQ(edit_distance("device", "dewice"), 1U);
    EXPECT_EQ(edit_distance("device", "devcie"), 1U);
    EXPECT_EQ(edit_distance("", "abc"), 3U);
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(SlipsBetween, DoesNotCountUpperCase) {
    EXPECT_EQ(edit_distance("Device", "DEVICE"), 0U);
}

constexpr std::array<std::string_view, 4> kNames{"to", "from", "failsafe", "channels"};

TEST(Nearest, FindsTheNameThatWasMeant) {
    EXPECT_EQ(nearest("form", kNames), "from");
    EXPECT_EQ(nearest("fail_safe", kNames), "failsafe");
    EXPECT_EQ(nearest("chanels", kNames), "channels");
}

TEST(Nearest, DoesNotGuessWhereNothingIsNear) {
    EXPECT_EQ(nearest("period", kNames), std::nullopt);
    EXPECT_EQ(nearest("x", kNames), std::nullopt);
    EXPECT_EQ(nearest("", kNames), std::nullopt);
}

TEST(Nearest, NeverTakesAWordOfWhichNothingIsLeft) {
    constexpr std::array<std::string_view, 1> kShort{"a"};
    EXPECT_EQ(nearest("b", kShort), std::nullopt);
}

TEST(Nearest, DoesNotCompareWordsOfAbsurdLength) {
    EXPECT_EQ(nearest(std::string(100'000, 'f'), kNames), std::nullopt);
}

TEST(SlipsBetween, AreCountedWhereverTheyAre) {
    struct Words {
        std::string_view a;
        std::string_view b;
        std::size_t slips;
    };
    for (const auto& [a, b, slips] : {
             Words{"", "", 0},         Words{"a", "", 1},
             Words{"a", "b", 1},       Words{"ab", "ba", 1},
             Words{"ab", "cd", 2},     Words{"abcd", "cdab", 4},
             Words{"abc", "cba", 2},   Words{"ca", "abc", 3},
             Words{"abcd", "acbd", 1}, Words{"abcd", "badc", 2},
             Words{"AZ", "za", 1},     Words{"Z", "z", 0},
             Words{"@", "`", 1},       Words{"[", "{", 1},
             Words{"ab", "axb", 1},    Words{"abcdef", "uvwxyz", 6},
             Words{"abab", "baba", 2}, Words{"aab", "aba", 1},
             Words{"abc", "", 3},      Words{"ab", "bc", 2},
             Words{"abxx", "baxx", 1},
         }) {
        EXPECT_EQ(edit_distance(a, b), slips) << a << " " << b;
        EXPECT_EQ(edit_distance(b, a), slips) << b << " " << a;
    }
}

std::string_view nearest_of(std::string_view wrong, const std::vector<std::string_view>& words) {
    return nearest(wrong, words).value_or("none");
}

TEST(Nearest, DiffersByAThirdOfTheLongerWordAtMost) {
    EXPECT_EQ(nearest_of("abcdxy", {"abcdef"}), "abcdef");
    EXPECT_EQ(nearest_of("abcxyz", {"abcdef"}), "none");
    EXPECT_EQ(nearest_of("abcxy", {"abcde"}), "none");
    EXPECT_EQ(nearest_of("abcd", {"abcdef"}), "abcdef");
    EXPECT_EQ(nearest_of("abcdef", {"abcd"}), "abcd");
    EXPECT_EQ(nearest_of("ax", {"ab"}), "ab");
    EXPECT_EQ(nearest_of("xy", {"ab"}), "none");
    EXPECT_EQ(nearest_of("", {"a"}), "none");
}

TEST(Nearest, IsTheFirstOfTheNearest) {
    EXPECT_EQ(nearest_of("ab", {"ac", "ad"}), "ac");
    EXPECT_EQ(nearest_of("abcdef", {"abcdxy", "abcdex"}), "abcdex");
    EXPECT_EQ(nearest_of("abcdef", {"abcdex", "abcdxy"}), "abcdex");
    EXPECT_EQ(nearest_of("abcdef", {"abcdex", "abcdef"}), "abcdef");
}

TEST(Nearest, ComparesWordsOfUpTo64Letters) {
    const std::string long_word(63, 'f');
    EXPECT_EQ(nearest_of(long_word + "g", {long_word}), long_word);
    EXPECT_EQ(nearest_of(long_word + "gg", {long_word}), "none");
}

}  // namespace
}  // namespace tribus::test::nearest_test
