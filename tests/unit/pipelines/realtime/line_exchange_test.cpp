#include "pipelines/realtime/line_exchange.h"

#include <gtest/gtest.h>
#include <poll.h>

#include <array>

namespace tribus::test::line_exchange_test {
namespace {

using namespace std::chrono_literals;

Instant at(Duration since_start) {
    return Instant(since_start);
}

bool is_set(int event) {
    pollfd polled{.fd = event, .events = POLLIN, .revents = 0};
    return ::poll(&polled, 1, 0) == 1;
}

class LineExchangeOfTwoOutputs : public testing::Test {
  protected:
    void SetUp() override { ASSERT_TRUE(exchange_.prepare()); }

    LineExchange exchange_{2};
};

TEST_F(LineExchangeOfTwoOutputs, BeginsWithAllLinesThereAndNoneActive) {
    EXPECT_EQ(exchange_.levels(at(0s)), kNoLineActive);
    EXPECT_EQ(exchange_.states(), LineStates{});
    EXPECT_FALSE(is_set(exchange_.data_event()));
    EXPECT_FALSE(is_set(exchange_.lines_event()));
}

TEST_F(LineExchangeOfTwoOutputs, TellsLevelsToTheDataThreadAndRingsWhenTheyChange) {
    exchange_.set_levels({1, 3}, at(0s));
    EXPECT_EQ(exchange_.levels(at(0s)), (LineLevels{1, 3}));
    EXPECT_TRUE(is_set(exchange_.data_event()));
    EXPECT_FALSE(is_set(exchange_.lines_event()));
    exchange_.clear_data_event();
    EXPECT_FALSE(is_set(exchange_.data_event()));
    exchange_.set_levels({1, 3}, at(0s));
    EXPECT_FALSE(is_set(exchange_.data_event())) << "nothing new";
    exchange_.set_levels({1, 1}, at(0s));
    EXPECT_TRUE(is_set(exchange_.data_event())) << "one is gone";
}

TEST_F(LineExchangeOfTwoOutputs, KnowsNoLineWhoseLevelsAreOlderThanASecond) {
    exchange_.set_levels({1, 3}, at(5s));
    EXPECT_EQ(exchange_.levels(at(6s)), (LineLevels{1, 3}));
    EXPECT_FALSE(exchange_.hangs(at(6s)));
    EXPECT_EQ(exchange_.levels(at(6s + 1ns)), LineLevels{});
    EXPECT_TRUE(exchange_.hangs(at(6s + 1ns)));
    exchange_.set_levels({1, 3}, at(7s));
    EXPECT_EQ(exchange_.levels(at(7s)), (LineLevels{1, 3}));
}

TEST_F(LineExchangeOfTwoOutputs, TellsStatesToTheLinesAndRingsWhenTheyChange) {
    exchange_.set_states({1, 2});
    EXPECT_EQ(exchange_.states(), (LineStates{1, 2}));
    EXPECT_TRUE(is_set(exchange_.lines_event()));
    EXPECT_FALSE(is_set(exchange_.data_event()));
    exchange_.clear_lines_event();
    exchange_.set_states({1, 2});
    EXPECT_FALSE(is_set(exchange_.lines_event())) << "nothing new";
    exchange_.wake_lines();
    EXPECT_TRUE(is_set(exchange_.lines_event()));
}

TEST_F(LineExchangeOfTwoOutputs, IsAsFreshAsTheStalestOutput) {
    constexpr std::array<std::size_t, 2> kBoth{0, 1};
    constexpr std::array<std::size_t, 1> kSecond{1};
    exchange_.set_fresh(1, at(5ms));
    EXPECT_EQ(exchange_.fresh_at(kBoth), Instant{}) << "the first never was";
    EXPECT_EQ(exchange_.fresh_at(kSecond), at(5ms));
    exchange_.set_fresh(0, at(7ms));
    EXPECT_EQ(exchange_.fresh_at(kBoth), at(5ms));
    exchange_.set_fresh(1, at(9ms));
    EXPECT_EQ(exchange_.fresh_at(kBoth), at(7ms));
    EXPECT_EQ(exchange_.fresh_at({}), Instant{}) << "of none, never";
}

}  // namespace
}  // namespace tribus::test::line_exchange_test
