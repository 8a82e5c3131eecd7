#include "pipelines/realtime/clock.h"

#include <chrono>
#include <cstdint>

#include <gtest/gtest.h>

namespace tribus::clock_test {
namespace {

TEST(AsTimespec, IsWholeSecondsAndTheRest) {
    const std::timespec time = as_timespec(std::chrono::milliseconds(2'500));
    EXPECT_EQ(time.tv_sec, 2);
    EXPECT_EQ(time.tv_nsec, 500'000'000);
}

/// 2^31 s after 1970 is in 2038.
TEST(AsTimespec, GoesOnAfter2038) {
    constexpr auto kSeconds = std::chrono::seconds(std::int64_t{1} << 31U);
    EXPECT_EQ(as_timespec(kSeconds).tv_sec, kSeconds.count());
}

TEST(AsTimespec, ANegativeTimeIsNone) {
    const std::timespec time = as_timespec(std::chrono::milliseconds(-1));
    EXPECT_EQ(time.tv_sec, 0);
    EXPECT_EQ(time.tv_nsec, 0);
}

}  // namespace
}  // namespace tribus::clock_test
