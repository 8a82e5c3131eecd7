#include "config/language/nearest.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

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

}  // namespace
}  // namespace tribus::test::nearest_test
