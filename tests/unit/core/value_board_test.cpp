#include "core/value_board.h"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>

namespace tribus::value_board_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kStart{5s};

class ValueBoardOfTwo : public testing::Test {
  protected:
    ValueBoard board_{{{.name = "battery.voltage", .unit = "V", .lasts = 1s},
                       {.name = "cells", .unit = "", .lasts = kForever}}};
};

TEST_F(ValueBoardOfTwo, FindsValuesByTheirNames) {
    EXPECT_EQ(board_.find("cells"), 1U);
    EXPECT_EQ(board_.value(0).unit, "V");
    EXPECT_EQ(board_.find("battery"), std::nullopt);
}

TEST_F(ValueBoardOfTwo, HasNoNumberBeforeTheFirst) {
    EXPECT_FALSE(board_.ever(0));
    EXPECT_EQ(board_.fresh(0, kStart), std::nullopt);
    EXPECT_EQ(board_.fresh_until(0), kNever);
}

TEST_F(ValueBoardOfTwo, GivesTheLatestNumberUntilItIsStale) {
    board_.set(0, 11.1, kStart - 2s);
    board_.set(0, 12.6, kStart, 3);
    EXPECT_EQ(board_.fresh(0, kStart + 1s), 12.6);
    EXPECT_EQ(board_.fresh_until(0), kStart + 1s);
    EXPECT_EQ(board_.fresh(0, kStart + 1s + 1ns), std::nullopt);
    EXPECT_EQ(board_.age(0, kStart + 3s), 3s);
    EXPECT_EQ(board_.tag(0), 3);
}

TEST_F(ValueBoardOfTwo, KeepsForeverWhatDoesNotGrowStale) {
    board_.set(1, 6, kStart);
    EXPECT_EQ(board_.fresh(1, kNever), 6);
    EXPECT_EQ(board_.fresh_until(1), kNever);
}

TEST_F(ValueBoardOfTwo, HasNoNumberOnceItsSourceSaysSo) {
    board_.set(0, 12.6, kStart, 3);
    board_.remove(0);
    EXPECT_EQ(board_.fresh(0, kStart), std::nullopt);
    EXPECT_TRUE(board_.ever(0));
    EXPECT_EQ(board_.tag(0), 3);
}

TEST_F(ValueBoardOfTwo, RemembersWhenItHadNoFreshNumber) {
    board_.set(0, 11.1, kStart);
    board_.set(0, 11.1, kStart + 1s);
    EXPECT_EQ(board_.gaps(0).count, 0U);
    EXPECT_EQ(board_.gaps(0).fresh_since, kStart);
    board_.set(0, 11.1, kStart + 2s + 1ns);
    EXPECT_EQ(board_.gaps(0).count, 1U);
    EXPECT_EQ(board_.gaps(0).stale_at, kStart + 2s);
    EXPECT_EQ(board_.gaps(0).fresh_since, kStart + 2s + 1ns);
}

TEST_F(ValueBoardOfTwo, RemembersThatItsSourceHadNoNumber) {
    board_.set(0, 11.1, kStart);
    board_.remove(0);
    board_.set(0, 11.1, kStart + 20ms);
    EXPECT_EQ(board_.gaps(0).count, 1U);
    EXPECT_EQ(board_.gaps(0).stale_at, kStart + 20ms);
    EXPECT_EQ(board_.gaps(0).fresh_since, kStart + 20ms);
}

TEST_F(ValueBoardOfTwo, HasNoGapBeforeTheFirstNumberAndWithoutALifetime) {
    board_.set(0, 11.1, kStart + 9s);
    board_.set(1, 6, kStart);
    board_.set(1, 6, kStart + 9s);
    EXPECT_EQ(board_.gaps(0).count, 0U);
    EXPECT_EQ(board_.gaps(1).count, 0U);
}

}  // namespace
}  // namespace tribus::value_board_test
