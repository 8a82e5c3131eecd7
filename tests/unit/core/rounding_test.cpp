#include "core/rounding.h"

#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

namespace tribus::rounding_test {
namespace {

TEST(NearestWhole, IsThatOfTheMathematicsLibraryAroundEveryHalf) {
    for (std::int64_t halves = -200'000; halves <= 200'000; ++halves) {
        const double value = static_cast<double>(halves) / 2;
        for (const double near : {value, std::nextafter(value, 1e9), std::nextafter(value, -1e9)}) {
            ASSERT_EQ(nearest_whole(near), std::llround(near)) << near;
        }
    }
}

TEST(NearestWhole, HoldsWhereADoubleHasNoHalvesAnyMore) {
    for (int exponent = 50; exponent <= 62; ++exponent) {
        const double value = std::ldexp(1.0, exponent) - (exponent < 53 ? 0.5 : 0.0);
        EXPECT_EQ(nearest_whole(value), std::llround(value)) << value;
        EXPECT_EQ(nearest_whole(-value), std::llround(-value)) << value;
    }
}

}  // namespace
}  // namespace tribus::rounding_test
