#include <cmath>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "transports/codecs/dronecan/float16.h"

namespace tribus::dronecan::float16_test {
namespace {

constexpr std::uint32_t kAll = 0x10000;
constexpr std::uint16_t kLargest = 0x7BFF;

bool is_nan(std::uint32_t half) {
    return (half & 0x7C00U) == 0x7C00U && (half & 0x3FFU) != 0;
}

/// Returns the value after the definition in IEEE 754, calculated with libm.
double by_definition(std::uint32_t half) {
    const double sign = (half & 0x8000U) != 0 ? -1 : 1;
    const int exponent = static_cast<int>((half >> 10U) & 0x1FU);
    const int mantissa = static_cast<int>(half & 0x3FFU);
    if (exponent == 31) {
        return sign * std::numeric_limits<double>::infinity();
    }
    return exponent == 0 ? sign * std::ldexp(mantissa, -24)
                         : sign * std::ldexp(mantissa + 1024, exponent - 25);
}

TEST(Float16, EveryNumberIsWhatTheStandardDefines) {
    for (std::uint32_t half = 0; half < kAll; ++half) {
        const float value = float_from_float16(static_cast<std::uint16_t>(half));
        if (is_nan(half)) {
            EXPECT_TRUE(std::isnan(value)) << half;
        } else {
            EXPECT_EQ(value, by_definition(half)) << half;
            EXPECT_EQ(std::signbit(value), half >= 0x8000U) << half;
        }
    }
}

TEST(Float16, EveryNumberComesBackAndWhateverIsNoneBecomesUnknown) {
    for (std::uint32_t half = 0; half < kAll; ++half) {
        const auto bits = static_cast<std::uint16_t>(half);
        EXPECT_EQ(float16_from_float(float_from_float16(bits)),
                  is_nan(half) ? kFloat16Unknown : bits);
    }
}

TEST(Float16, BetweenTwoNumbersTheNearestIsTakenAndInTheMiddleTheEvenOne) {
    for (std::uint16_t half = 0; half < kLargest; ++half) {
        const auto next = static_cast<std::uint16_t>(half + 1);
        const float middle = (float_from_float16(half) + float_from_float16(next)) / 2;
        EXPECT_EQ(float16_from_float(std::nextafter(middle, 0.0F)), half);
        EXPECT_EQ(float16_from_float(middle), half % 2 == 0 ? half : next);
        EXPECT_EQ(float16_from_float(std::nextafter(middle, 1e6F)), next);
        EXPECT_EQ(float16_from_float(-middle), (half % 2 == 0 ? half : next) | 0x8000U);
    }
}

TEST(Float16, WhatIsTooLargeIsSaturatedButInfinityIsNot) {
    EXPECT_EQ(float16_from_float(65519.0F), kLargest);
    EXPECT_EQ(float16_from_float(65520.0F), kLargest);
    EXPECT_EQ(float16_from_float(std::numeric_limits<float>::max()), kLargest);
    EXPECT_EQ(float16_from_float(-std::numeric_limits<float>::max()), kLargest | 0x8000U);
    EXPECT_EQ(float16_from_float(std::numeric_limits<float>::infinity()), 0x7C00);
    EXPECT_EQ(float16_from_float(-std::numeric_limits<float>::infinity()), 0xFC00);
}

TEST(Float16, WhatIsTooSmallBecomesZeroOfItsSign) {
    EXPECT_EQ(float16_from_float(0x1p-26F), 0);
    EXPECT_EQ(float16_from_float(-0x1p-26F), 0x8000);
    EXPECT_EQ(float16_from_float(std::numeric_limits<float>::denorm_min()), 0);
}

}  // namespace
}  // namespace tribus::dronecan::float16_test
