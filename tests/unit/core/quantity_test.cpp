#include "core/quantity.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace tribus::quantity_test {
namespace {

using std::chrono::hours;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

TEST(ParseQuantity, SplitsTheNumberFromWhateverStandsBehindIt) {
    const auto whole = parse_quantity("2000us/s");
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->number, 2000.0);
    EXPECT_EQ(whole->unit, "us/s");
    const auto fraction = parse_quantity("0.25 of it");
    ASSERT_TRUE(fraction);
    EXPECT_EQ(fraction->number, 0.25);
    EXPECT_EQ(fraction->unit, " of it");
}

TEST(ParseQuantity, NeedsNoUnit) {
    const auto quantity = parse_quantity("42");
    ASSERT_TRUE(quantity);
    EXPECT_EQ(quantity->number, 42.0);
    EXPECT_EQ(quantity->unit, "");
}

TEST(ParseQuantity, TakesAnExponentForAUnit) {
    const auto quantity = parse_quantity("1e3");
    ASSERT_TRUE(quantity);
    EXPECT_EQ(quantity->number, 1.0);
    EXPECT_EQ(quantity->unit, "e3");
}

TEST(ParseQuantity, RefusesWhatDoesNotBeginWithAWholeNumber) {
    for (const std::string_view text : {"", "ms", "-1ms", "+1ms", " 1ms", ".5s", "5.", "5.s"}) {
        EXPECT_FALSE(parse_quantity(text)) << text;
    }
}

TEST(ParseQuantity, RefusesANumberThatNoTypeHolds) {
    EXPECT_FALSE(parse_quantity(std::string(400, '9')));
}

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

TEST(ParseDuration, EndsBeyondALeapYear) {
    EXPECT_EQ(parse_duration("31622400s"), hours(366 * 24));
    EXPECT_EQ(parse_duration("31622401s"), std::nullopt);
}

TEST(ParseDuration, RoundsToWholeNanoseconds) {
    EXPECT_EQ(parse_duration("0.0004us"), nanoseconds(0));
    EXPECT_EQ(parse_duration("0.0006us"), nanoseconds(1));
}

}  // namespace
}  // namespace tribus::quantity_test
