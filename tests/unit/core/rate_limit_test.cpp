#include "core/rate_limit.h"

#include <gtest/gtest.h>

namespace tribus::rate_limit_test {
namespace {

using namespace std::chrono_literals;

TEST(RateLimit, LetsABurstPassAndThenCountsThoseItSuppressed) {
    RateLimit limit(2, 10s);
    EXPECT_EQ(limit.pass(Instant(0s)), 0U);
    EXPECT_EQ(limit.pass(Instant(1s)), 0U);
    EXPECT_EQ(limit.pass(Instant(2s)), std::nullopt);
    EXPECT_EQ(limit.pass(Instant(9s)), std::nullopt);
    EXPECT_EQ(limit.pass(Instant(10s)), 2U);
    EXPECT_EQ(limit.pass(Instant(11s)), 0U);
}

}  // namespace
}  // namespace tribus::rate_limit_test
