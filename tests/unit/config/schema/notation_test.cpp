#include "config/schema/notation.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <chrono>
#include <optional>

namespace tribus::test::notation_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

TEST(FormatDuration, UsesTheLargestUnitThatNeedsNoFraction) {
    EXPECT_EQ(format_duration(seconds(2)), "2s");
    EXPECT_EQ(format_duration(milliseconds(14)), "14ms");
    EXPECT_EQ(format_duration(milliseconds(1500)), "1500ms");
    EXPECT_EQ(format_duration(microseconds(1500)), "1500us");
    EXPECT_EQ(format_duration(nanoseconds(1500)), "1.5us");
    EXPECT_EQ(format_duration(nanoseconds(0)), "0s");
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
}  // namespace tribus::test::notation_test
