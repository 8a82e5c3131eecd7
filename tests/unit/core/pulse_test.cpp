#include "core/pulse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace tribus::pulse_test {
namespace {

constexpr std::int32_t kLeast = -32768;
constexpr std::int32_t kMost = 32767;

TEST(Pulse, DefaultIsZero) {
    EXPECT_EQ(Pulse{}.eighths(), 0);
}

TEST(Pulse, KeepsEveryNumberOfEighthsThatItCanHold) {
    for (std::int32_t eighths = kLeast; eighths <= kMost; ++eighths) {
        ASSERT_EQ(Pulse::from_eighths(eighths).eighths(), eighths);
        ASSERT_EQ(Pulse::from_eighths(eighths).microseconds(), eighths / 8.0);
    }
}

TEST(Pulse, KeepsEveryWholeMicrosecondThatIbusCanSend) {
    for (std::int32_t microseconds = 0; microseconds <= 4095; ++microseconds) {
        const Pulse pulse = Pulse::from_microseconds(microseconds);
        ASSERT_EQ(pulse.eighths(), 8 * microseconds);
        ASSERT_EQ(pulse.whole_microseconds(), microseconds);
    }
}

TEST(Pulse, RoundsToTheNearestWholeMicrosecondAndHalvesUpwards) {
    for (std::int32_t eighths = kLeast; eighths <= kMost; ++eighths) {
        // Readers take a word of 4096 for no pulse.
        const std::int32_t nearest = static_cast<std::int32_t>(std::floor(eighths / 8.0 + 0.5));
        ASSERT_EQ(Pulse::from_eighths(eighths).whole_microseconds(), std::min(nearest, 4095))
            << eighths << " eighths";
    }
}

TEST(Pulse, SaturatesInsteadOfWrapping) {
    using Limits = std::numeric_limits<std::int64_t>;
    EXPECT_EQ(Pulse::from_eighths(kMost + 1).eighths(), kMost);
    EXPECT_EQ(Pulse::from_eighths(kLeast - 1).eighths(), kLeast);
    EXPECT_EQ(Pulse::from_eighths(Limits::max()).eighths(), kMost);
    EXPECT_EQ(Pulse::from_eighths(Limits::min()).eighths(), kLeast);
    EXPECT_EQ(Pulse::from_microseconds(4096).eighths(), kMost);
    EXPECT_EQ(Pulse::from_microseconds(-4097).eighths(), kLeast);
    EXPECT_EQ(Pulse::from_microseconds(Limits::max()).eighths(), kMost);
    EXPECT_EQ(Pulse::from_microseconds(Limits::min()).eighths(), kLeast);
}

TEST(Pulse, TakesFractionsToTheNearestEighth) {
    EXPECT_EQ(Pulse::from_fractional_microseconds(1500.5).eighths(), 12004);
    EXPECT_EQ(Pulse::from_fractional_microseconds(2159.375).eighths(), 17275);
    EXPECT_EQ(Pulse::from_fractional_microseconds(1500.06).eighths(), 12000);
    EXPECT_EQ(Pulse::from_fractional_microseconds(1500.07).eighths(), 12001);
    EXPECT_EQ(Pulse::from_fractional_microseconds(-0.07).eighths(), -1);
}

TEST(Pulse, TakesAnyFloatingPointNumber) {
    using Limits = std::numeric_limits<double>;
    EXPECT_EQ(Pulse::from_fractional_microseconds(Limits::quiet_NaN()).eighths(), 0);
    EXPECT_EQ(Pulse::from_fractional_microseconds(Limits::infinity()).eighths(), kMost);
    EXPECT_EQ(Pulse::from_fractional_microseconds(-Limits::infinity()).eighths(), kLeast);
    EXPECT_EQ(Pulse::from_fractional_microseconds(1e300).eighths(), kMost);
    EXPECT_EQ(Pulse::from_fractional_microseconds(-1e300).eighths(), kLeast);
}

TEST(Pulse, OrdersByWidth) {
    EXPECT_LT(Pulse::from_eighths(-1), Pulse{});
    EXPECT_LT(kSwitchOffPulse, kCentrePulse);
    EXPECT_LT(kCentrePulse, kSwitchOnPulse);
    EXPECT_EQ(Pulse::from_microseconds(1500), kCentrePulse);
}

}  // namespace
}  // namespace tribus::pulse_test
