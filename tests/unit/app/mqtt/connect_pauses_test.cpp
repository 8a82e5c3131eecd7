#include "app/mqtt/connect_pauses.h"

#include <chrono>
#include <cstdint>
#include <map>

#include <gtest/gtest.h>

/// Pauses between attempts to connect to a broker.
namespace tribus::mqtt::connect_pauses_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kBoards = 10'000;

TEST(ConnectPausesTest, DoublesUpToTheLastLimit) {
    for (std::uint32_t seed = 1; seed <= kBoards; ++seed) {
        ConnectPauses pauses(seed);
        for (const Duration limit : {2s, 4s, 8s, 16s, 30s, 30s, 30s}) {
            const Duration pause = pauses.next();
            ASSERT_GE(pause, limit / 2) << seed;
            ASSERT_LE(pause, limit) << seed;
        }
    }
}

TEST(ConnectPausesTest, BeginsAnewAfterAConnection) {
    ConnectPauses pauses(1);
    for (int i = 0; i < 6; ++i) {
        pauses.next();
    }
    pauses.connected();
    EXPECT_LE(pauses.next(), ConnectPauses::kFirstLimit);
}

/// Boards that lost their broker at once, which is back after 10 s: when each of them comes.
TEST(ConnectPausesTest, SpreadsManyBoards) {
    constexpr Duration kAway = 10s;
    std::map<std::chrono::seconds, std::uint32_t> come;
    for (std::uint32_t board = 0; board < kBoards; ++board) {
        // Seeds as a program has them: without any order.
        ConnectPauses pauses(board * 2'654'435'761U);
        Duration at{};
        while (at < kAway) {
            at += pauses.next();
        }
        ++come[std::chrono::floor<std::chrono::seconds>(at)];
    }
    for (const auto& [second, boards] : come) {
        EXPECT_LT(boards, kBoards / 3) << "in second " << second.count();
    }
}

}  // namespace
}  // namespace tribus::mqtt::connect_pauses_test
