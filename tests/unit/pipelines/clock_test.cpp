#include "pipelines/realtime/clock.h"

#include <chrono>

#include <gtest/gtest.h>

namespace tribus {
namespace {

TEST(AsTimespec, IsWholeSecondsAndTheRest) {
    const std::timespec time = as_timespec(std::chrono::milliseconds(2'500));
    EXPECT_EQ(time.tv_sec, 2);
    EXPECT_EQ(time.tv_nsec, 500'000'000);
}

TEST(AsTimespec, ANegativeTimeIsNone) {
    const std::timespec time = as_timespec(std::chrono::milliseconds(-1));
    EXPECT_EQ(time.tv_sec, 0);
    EXPECT_EQ(time.tv_nsec, 0);
}

}  // namespace
}  // namespace tribus
