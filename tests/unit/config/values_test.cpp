#include "config/values.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <chrono>
#include <limits>

namespace tribus::testing {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

struct DurationCase {
    std::string_view text;
    std::optional<Duration> expected;
};

constexpr std::array kDurations{
    DurationCase{"500us", microseconds(500)},
    DurationCase{"14ms", milliseconds(14)},
    DurationCase{"2s", seconds(2)},
    DurationCase{"0ms", milliseconds(0)},
    DurationCase{"1.5s", milliseconds(1500)},
    DurationCase{"7.2ms", microseconds(7200)},
    DurationCase{"0.001us", nanoseconds(1)},
    DurationCase{"007ms", milliseconds(7)},
    DurationCase{"", std::nullopt},
    DurationCase{"ms", std::nullopt},
    DurationCase{"14", std::nullopt},
    DurationCase{"14 ms", std::nullopt},
    DurationCase{" 14ms", std::nullopt},
    DurationCase{"14ms ", std::nullopt},
    DurationCase{"-14ms", std::nullopt},
    DurationCase{"+14ms", std::nullopt},
    DurationCase{"1e3ms", std::nullopt},
    DurationCase{"0x10ms", std::nullopt},
    DurationCase{".5s", std::nullopt},
    DurationCase{"5.s", std::nullopt},
    DurationCase{"1.2.3s", std::nullopt},
    DurationCase{"infs", std::nullopt},
    DurationCase{"nans", std::nullopt},
    DurationCase{"14MS", std::nullopt},
    DurationCase{"14min", std::nullopt},
    DurationCase{"14ns", std::nullopt},
    DurationCase{"99999999999s", std::nullopt},
};

TEST(ParseDuration, TakesDigitsAFractionAndAUnitAndNothingElse) {
    for (const DurationCase& duration : kDurations) {
        EXPECT_EQ(parse_duration(duration.text), duration.expected) << duration.text;
    }
}

TEST(ParseDuration, RefusesANumberThatNoTypeHolds) {
    EXPECT_EQ(parse_duration(std::string(400, '9') + "s"), std::nullopt);
}

TEST(FormatDuration, UsesTheLargestUnitThatNeedsNoFraction) {
    EXPECT_EQ(format_duration(seconds(2)), "2s");
    EXPECT_EQ(format_duration(milliseconds(14)), "14ms");
    EXPECT_EQ(format_duration(milliseconds(1500)), "1500ms");
    EXPECT_EQ(format_duration(microseconds(1500)), "1500us");
    EXPECT_EQ(format_duration(nanoseconds(1500)), "1.5us");
    EXPECT_EQ(format_duration(nanoseconds(0)), "0ms");
}

RC_GTEST_PROP(FormatDuration, ParsesBackToTheSame, ()) {
    const Duration duration(*rc::gen::inRange<std::int64_t>(0, 60'000'000'000));
    RC_ASSERT(parse_duration(format_duration(duration)) == duration);
}

TEST(ParseSlew, TakesMicrosecondsASecondOnly) {
    EXPECT_EQ(parse_slew("2000us/s"), 2000.0);
    EXPECT_EQ(parse_slew("0.5us/s"), 0.5);
    EXPECT_EQ(parse_slew("2000us"), std::nullopt);
    EXPECT_EQ(parse_slew("2000 us/s"), std::nullopt);
    EXPECT_EQ(parse_slew("2ms/s"), std::nullopt);
    EXPECT_EQ(parse_slew(format_slew(1234.5)), 1234.5);
}

}  // namespace
}  // namespace tribus::testing
