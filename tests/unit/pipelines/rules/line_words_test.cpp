#include "pipelines/rules/line_words.h"

#include <gtest/gtest.h>

#include <optional>

namespace tribus::test::line_words_test {
namespace {

TEST(LineLevels, TellWhetherALineIsActiveUntilItCannotBeRead) {
    LineLevels levels;
    levels.set(3, true);
    EXPECT_EQ(levels.of(3), true);
    levels.set(3, false);
    EXPECT_EQ(levels.of(3), false);
    levels.set(3, std::nullopt);
    EXPECT_EQ(levels.of(3), std::nullopt);
}

TEST(LineLevels, StayForOtherLines) {
    LineLevels levels = kNoLineActive;
    levels.set(31, true);
    levels.set(0, std::nullopt);
    EXPECT_EQ(levels.of(31), true);
    EXPECT_EQ(levels.of(30), false);
    EXPECT_EQ(levels.of(0), std::nullopt);
}

}  // namespace
}  // namespace tribus::test::line_words_test
