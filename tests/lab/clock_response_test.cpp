#include <chrono>

#include <gtest/gtest.h>

#include "app/bench/distribution.h"
#include "tests/bench/response_times.h"

/// The built program in a guest whose time is the number of executed instructions: an idle machine
/// with one slow processor, whatever the host does.
namespace tribus::test::clock_response_test {
namespace {

BoundSettings fifteen_seconds() {
    BoundSettings settings;
    settings.program = TRIBUS_PROGRAM;
    settings.length = std::chrono::seconds(15);
    return settings;
}

TEST(LabResponse, LeavesWithinTheProvenWindowInNineHundredNinetyNineOfAThousandSlots) {
    const auto times = response_times(fifteen_seconds());
    ASSERT_TRUE(times) << times.error();
    for (const Responses* responses : {&times->at_once, &times->by_default}) {
        EXPECT_LT(responses->times.percentile(99.9), kResponseWindow);
        EXPECT_EQ(responses->missed, 0U);
    }
}

TEST(LabResponse, TakesLittleLongerThanAResponderThatOnlyReadsAndWrites) {
    const auto times = response_times(fifteen_seconds());
    ASSERT_TRUE(times) << times.error();
    const auto bare = times->bare.times.percentile(50);
    EXPECT_LT(bench::ratio_of(times->at_once.times.percentile(50), bare), 1.25);
    EXPECT_LT(bench::ratio_of(times->by_default.times.percentile(50) - kDefaultReplyAfter, bare),
              1.25);
}

}  // namespace
}  // namespace tribus::test::clock_response_test
