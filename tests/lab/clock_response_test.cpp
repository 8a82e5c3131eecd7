#include <chrono>
#include <string>

#include <gtest/gtest.h>
#include <tl/expected.hpp>

#include "core/distribution.h"
#include "tests/bench/response_times.h"

/// The built program in a guest whose time is the number of executed instructions: an idle machine
/// with one slow processor, whatever the host does.
namespace tribus::test::clock_response_test {
namespace {

/// Measures once; every test judges the same 15 s.
class LabResponse : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        BoundSettings settings;
        settings.program = TRIBUS_PROGRAM;
        settings.length = std::chrono::seconds(15);
        times = response_times(settings);
    }

    void SetUp() override { ASSERT_TRUE(times) << times.error(); }

    static inline tl::expected<ResponseTimes, std::string> times{tl::unexpect, "not measured"};
};

TEST_F(LabResponse, LeavesWithinTheProvenWindowInNineHundredNinetyNineOfAThousandSlots) {
    for (const Responses* responses : {&times->at_once, &times->by_default}) {
        EXPECT_LT(responses->times.percentile(99.9), kResponseWindow);
        EXPECT_EQ(responses->missed, 0U);
    }
}

TEST_F(LabResponse, TakesLittleLongerThanAResponderThatOnlyReadsAndWrites) {
    const auto bare = times->bare.times.percentile(50);
    EXPECT_LT(ratio_of(times->at_once.times.percentile(50), bare), 1.25);
    EXPECT_LT(ratio_of(times->by_default.times.percentile(50) - kDefaultReplyAfter, bare), 1.25);
}

}  // namespace
}  // namespace tribus::test::clock_response_test
