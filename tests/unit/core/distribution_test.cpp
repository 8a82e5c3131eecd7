#include "core/distribution.h"

#include <chrono>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::distribution_test {
namespace {

using std::chrono::microseconds;

Distribution one_to(int most) {
    std::vector<Duration> samples;
    for (int i = most; i > 0; --i) {
        samples.push_back(microseconds(i));
    }
    return Distribution(std::move(samples));
}

TEST(Distribution, APercentileIsTheSmallestSampleThatCoversThatShare) {
    const Distribution hundred = one_to(100);
    EXPECT_EQ(hundred.percentile(50), microseconds(50));
    EXPECT_EQ(hundred.percentile(99), microseconds(99));
    EXPECT_EQ(hundred.percentile(99.1), microseconds(100));
    EXPECT_EQ(one_to(3).percentile(50), microseconds(2));
}

TEST(Distribution, ZeroIsTheLeastAndAHundredTheMost) {
    EXPECT_EQ(one_to(7).percentile(0), microseconds(1));
    EXPECT_EQ(one_to(7).percentile(100), microseconds(7));
}

TEST(Distribution, HasZeroForEveryPercentileOfNothing) {
    EXPECT_EQ(Distribution().percentile(99), Duration::zero());
}

TEST(NoiseAllowance, IsWhatTheAnchorDoesBesideItself) {
    EXPECT_DOUBLE_EQ(noise_allowance(microseconds(100), microseconds(125)), 1.25);
}

TEST(NoiseAllowance, NeverTightensABound) {
    EXPECT_DOUBLE_EQ(noise_allowance(microseconds(100), microseconds(80)), 1.0);
}

TEST(Ratio, ToNothingIsZero) {
    EXPECT_DOUBLE_EQ(ratio_of(microseconds(3), Duration::zero()), 0);
    EXPECT_DOUBLE_EQ(ratio_of(microseconds(3), microseconds(4)), 0.75);
}

}  // namespace
}  // namespace tribus::distribution_test
