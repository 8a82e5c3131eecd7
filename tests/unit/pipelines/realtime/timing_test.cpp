#include "pipelines/realtime/timing.h"

#include <gtest/gtest.h>

#include <chrono>

namespace tribus::test::timing_test {
namespace {

using namespace std::chrono_literals;

Instant at(Duration since_start) {
    return Instant(since_start);
}

FrameTimes frame_due(Duration due, Duration late, Duration read) {
    return {.due = at(due),
            .taken = at(due + late),
            .handed_over = at(due + late + 20us),
            .read = at(read),
            .period = 10ms};
}

TEST(InputTiming, TellsTheAgeOfEachFrameWhenTheNextOneCame) {
    InputTiming timing;
    timing.frame_came(at(100ms));
    EXPECT_EQ(timing.age().since_start().count(), 0U) << "there was none before";
    timing.frame_came(at(107ms));
    timing.frame_came(at(116ms));
    EXPECT_EQ(timing.age().since_start().count(), 2U);
    EXPECT_EQ(timing.age().since_start().worst, 9ms);
}

TEST(OutputTiming, TellsHowLateValuesWereTaken) {
    OutputTiming timing;
    timing.frame_went(frame_due(100ms, 300us, 99ms));
    EXPECT_EQ(timing.lateness().since_start().count(), 1U);
    EXPECT_EQ(timing.lateness().since_start().worst, 300us);
}

TEST(OutputTiming, AFrameMissesItsDeadlineWhereItIsLateByMoreThanATenthOfItsPeriod) {
    OutputTiming timing;
    timing.frame_went(frame_due(100ms, 1ms, 99ms));
    EXPECT_EQ(timing.deadline_misses(), 0U);
    timing.frame_went(frame_due(110ms, 1ms + 1ns, 109ms));
    EXPECT_EQ(timing.deadline_misses(), 1U);
    timing.frame_went(frame_due(120ms, 9ms, 119ms));
    EXPECT_EQ(timing.deadline_misses(), 2U);
}

TEST(OutputTiming, TellsTheLatencyOfValuesWhereTheyAreHandedOverFirst) {
    OutputTiming timing;
    timing.frame_went(frame_due(100ms, 0ms, 97ms));
    EXPECT_EQ(timing.latency().since_start().worst, 3ms + 20us);
    timing.frame_went(frame_due(110ms, 0ms, 97ms));
    EXPECT_EQ(timing.latency().since_start().count(), 1U) << "the same values again";
    timing.frame_went(frame_due(120ms, 0ms, 119ms));
    EXPECT_EQ(timing.latency().since_start().count(), 2U);
}

TEST(OutputTiming, PresetsHaveNoLatency) {
    OutputTiming timing;
    timing.frame_went(frame_due(100ms, 0ms, 97ms));
    timing.frame_went(frame_due(110ms, 0ms, 0ms));
    EXPECT_EQ(timing.latency().since_start().count(), 1U);
    EXPECT_EQ(timing.latency().since_start().worst, 3ms + 20us);
}

}  // namespace
}  // namespace tribus::test::timing_test
