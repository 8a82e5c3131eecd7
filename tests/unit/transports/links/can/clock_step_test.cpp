#include "transports/links/can/clock_step.h"

#include <chrono>

#include <gtest/gtest.h>

namespace tribus::clock_step_test {
namespace {

using namespace std::chrono_literals;

constexpr Duration kWall = 1'000'000s;
constexpr Instant kNow = Instant(1h);

TEST(ClockStepTest, IsWhatTheSystemClockDidMoreThanTimePassed) {
    ClockStep step;
    step.look(kWall, kNow);
    EXPECT_FALSE(step.since_last_look(kWall + 20ms, kNow + 20ms));
    EXPECT_TRUE(step.since_last_look(kWall + 5s, kNow + 20ms));
    EXPECT_TRUE(step.since_last_look(kWall - 5s, kNow + 20ms));
}

/// Set back by nearly the time without a read: the oldest frames would look like the youngest.
TEST(ClockStepTest, HidesBehindNoStall) {
    ClockStep step;
    step.look(kWall, kNow);
    EXPECT_TRUE(step.since_last_look(kWall + 50ms, kNow + 2s));
}

TEST(ClockStepTest, IsNoSlewing) {
    ClockStep step;
    step.look(kWall, kNow);
    EXPECT_FALSE(step.since_last_look(kWall + 60s + 30ms, kNow + 60s));
}

TEST(ClockStepTest, IsUnknownBeforeTheFirstLook) {
    EXPECT_FALSE(ClockStep().since_last_look(kWall, kNow));
}

}  // namespace
}  // namespace tribus::clock_step_test
