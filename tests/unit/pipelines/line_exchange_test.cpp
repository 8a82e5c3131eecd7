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

bool rings(int bell) {
    pollfd polled{.fd = bell, .events = POLLIN, .revents = 0};
    return ::poll(&polled, 1, 0) == 1;
}

class LineExchangeOfTwoOutputs : public testing::Test {
  protected:
    void SetUp() override { ASSERT_TRUE(exchange_.prepare()); }

    LineExchange exchange_{2};
};

TEST_F(LineExchangeOfTwoOutputs, BeginsWithAllLinesThereAndNoneActive) {
    EXPECT_EQ(exchange_.levels(), kNoLineActive);
    EXPECT_EQ(exchange_.states(), LineStates{});
    EXPECT_FALSE(rings(exchange_.data_bell()));
    EXPECT_FALSE(rings(exchange_.lines_bell()));
}

TEST_F(LineExchangeOfTwoOutputs, TellsLevelsToTheDataThreadAndRingsWhenTheyChange) {
    exchange_.tell_levels({1, 3});
    EXPECT_EQ(exchange_.levels(), (LineLevels{1, 3}));
    EXPECT_TRUE(rings(exchange_.data_bell()));
    EXPECT_FALSE(rings(exchange_.lines_bell()));
    exchange_.hush_data();
    EXPECT_FALSE(rings(exchange_.data_bell()));
    exchange_.tell_levels({1, 3});
    EXPECT_FALSE(rings(exchange_.data_bell())) << "nothing new";
    exchange_.tell_levels({1, 1});
    EXPECT_TRUE(rings(exchange_.data_bell())) << "one is gone";
}

TEST_F(LineExchangeOfTwoOutputs, TellsStatesToTheLinesAndRingsWhenTheyChange) {
    exchange_.tell_states({1, 2});
    EXPECT_EQ(exchange_.states(), (LineStates{1, 2}));
    EXPECT_TRUE(rings(exchange_.lines_bell()));
    EXPECT_FALSE(rings(exchange_.data_bell()));
    exchange_.hush_lines();
    exchange_.tell_states({1, 2});
    EXPECT_FALSE(rings(exchange_.lines_bell())) << "nothing new";
    exchange_.ring_lines();
    EXPECT_TRUE(rings(exchange_.lines_bell()));
}

TEST_F(LineExchangeOfTwoOutputs, IsAsFreshAsTheStalestOutput) {
    constexpr std::array<std::size_t, 2> kBoth{0, 1};
    constexpr std::array<std::size_t, 1> kSecond{1};
    exchange_.tell_fresh(1, at(5ms));
    EXPECT_EQ(exchange_.fresh_at(kBoth), Instant{}) << "the first never was";
    EXPECT_EQ(exchange_.fresh_at(kSecond), at(5ms));
    exchange_.tell_fresh(0, at(7ms));
    EXPECT_EQ(exchange_.fresh_at(kBoth), at(5ms));
    exchange_.tell_fresh(1, at(9ms));
    EXPECT_EQ(exchange_.fresh_at(kBoth), at(7ms));
    EXPECT_EQ(exchange_.fresh_at({}), Instant{}) << "of none, never";
}

}  // namespace
}  // namespace tribus::test::line_exchange_test
