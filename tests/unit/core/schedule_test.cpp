#include "core/schedule.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/core/arrivals.h"

namespace tribus::test::schedule_test {
namespace {

using namespace test::arrivals;

using namespace std::chrono_literals;

/// The latest frame was written when it arrived.
Schedule written_on_arrival(Duration period, const ArrivalClock& arrivals) {
    Schedule schedule({.kind = ScheduleKind::follow, .period = period});
    schedule.start(at(0ms));
    schedule.frame_arrived(arrivals);
    schedule.done(arrivals.latest(), true);
    return schedule;
}

TEST(FollowSchedule, WaitsAPeriodForAFirstFrame) {
    Schedule schedule({.kind = ScheduleKind::follow, .period = 7ms});
    schedule.start(at(100ms));
    EXPECT_EQ(schedule.due(), at(107ms));
}

TEST(FollowSchedule, AFirstFrameIsDueAtOnce) {
    Schedule schedule({.kind = ScheduleKind::follow, .period = 7ms});
    schedule.start(at(0ms));
    schedule.frame_arrived(arrivals_each(4ms, at(2ms), 1));
    EXPECT_EQ(schedule.due(), at(2ms));
}

TEST(FollowSchedule, AFrameThatComesTooSoonWaitsUntilThePeriodHasPassed) {
    Schedule schedule({.kind = ScheduleKind::follow, .period = 7ms});
    schedule.start(at(0ms));
    schedule.frame_arrived(arrivals_each(5ms, at(2ms), 1));
    schedule.done(at(2ms), true);
    schedule.frame_arrived(arrivals_each(5ms, at(2ms), 2));
    EXPECT_EQ(schedule.due(), at(9ms));
}

TEST(FollowSchedule, SendsTheLaterOfTwoFramesThatComeTooSoonIfItNeedNotWait) {
    // 4 ms in, 7 ms out: the frame at 4 ms would be written at 7 ms and delay the one at 8 ms until
    // 14 ms.
    Schedule schedule({.kind = ScheduleKind::follow, .period = 7ms});
    schedule.start(at(0ms));
    schedule.frame_arrived(arrivals_each(4ms, at(0ms), 10));
    schedule.done(at(36ms), true);
    schedule.frame_arrived(arrivals_each(4ms, at(0ms), 11));
    EXPECT_GT(schedule.due(), at(44ms));
    schedule.frame_arrived(arrivals_each(4ms, at(0ms), 12));
    EXPECT_EQ(schedule.due(), at(44ms));
}

/// 7 ms in and out, so nothing else would ever catch up with a delay. Returns the age of each
/// written frame.
std::vector<Duration> ages_after_a_stall_of(Duration stall, Duration least_spacing = 7ms) {
    Schedule schedule(
        {.kind = ScheduleKind::follow, .period = 7ms, .least_spacing = least_spacing});
    schedule.start(at(0ms));
    ArrivalClock arrivals = arrivals_each(7ms, at(0ms), 100);
    schedule.frame_arrived(arrivals);
    schedule.done(arrivals.latest() + stall, true);
    std::vector<Duration> ages;
    for (int i = 100; i < 150; ++i) {
        const Instant arrival = at(i * 7ms);
        if (schedule.due() < arrival) {
            ages.push_back(schedule.due() - arrivals.latest());
            schedule.done(schedule.due(), true);
        }
        arrivals.arrived(arrival);
        schedule.frame_arrived(arrivals);
    }
    return ages;
}

TEST(FollowSchedule, ALongStallHoldsUpNoFrameButItsOwn) {
    for (const Duration age : ages_after_a_stall_of(4ms)) {
        EXPECT_EQ(age, 0ms);
    }
}

TEST(FollowSchedule, AShortStallHoldsUpAFewFramesAndNotAllThatFollow) {
    const std::vector<Duration> ages = ages_after_a_stall_of(2ms);
    ASSERT_EQ(ages.size(), 48U) << "one frame was left out";
    for (std::size_t i = 0; i < ages.size(); ++i) {
        EXPECT_EQ(ages[i], i < 8 ? 2ms : 0ms) << i;
    }
}

TEST(FollowSchedule, AStallHoldsUpNoFrameThatMayFollowTheLateOneSooner) {
    for (const Duration age : ages_after_a_stall_of(2ms, 5ms)) {
        ASSERT_EQ(age, 0ms);
    }
}

TEST(FollowSchedule, BehindALateFrameEachFrameKeepsTheLeastSpacing) {
    // 3 ms late: the next one 6 ms behind it is 2 ms late, and the one behind that 1 ms.
    const std::vector<Duration> ages = ages_after_a_stall_of(3ms, 6ms);
    EXPECT_EQ(ages[0], 2ms);
    EXPECT_EQ(ages[1], 1ms);
    EXPECT_EQ(ages[2], 0ms);
}

TEST(FollowSchedule, FramesThatComeMoreOftenThanThePeriodKeepThePeriod) {
    Schedule schedule({.kind = ScheduleKind::follow, .period = 10ms, .least_spacing = 2ms});
    schedule.start(at(0ms));
    ArrivalClock arrivals;
    std::vector<Instant> writes;
    for (int i = 0; i < 1000; ++i) {
        arrivals.arrived(at(i * 3ms));
        schedule.frame_arrived(arrivals);
        while (schedule.due() <= at(i * 3ms + 2999us)) {
            writes.push_back(schedule.due());
            schedule.done(schedule.due(), true);
        }
    }
    ASSERT_GT(writes.size(), 250U);
    for (std::size_t i = 1; i < writes.size(); ++i) {
        ASSERT_GE(writes[i] - writes[i - 1], 10ms) << i;
    }
}

TEST(FollowSchedule, AFrameAfterThePeriodIsDueOnArrival) {
    Schedule schedule({.kind = ScheduleKind::follow, .period = 7ms});
    schedule.start(at(0ms));
    schedule.done(at(7ms), true);
    schedule.frame_arrived(arrivals_each(7700us, at(8ms), 2));
    EXPECT_EQ(schedule.due(), at(15700us));
}

TEST(FollowSchedule, RepeatsOnceAPeriodWithoutInput) {
    Schedule schedule({.kind = ScheduleKind::follow, .period = 7ms});
    schedule.start(at(0ms));
    for (int period = 1; period <= 100; ++period) {
        ASSERT_EQ(schedule.due(), at(period * 7ms));
        schedule.done(schedule.due(), true);
    }
}

TEST(FollowSchedule, ARepeatWaitsForAFrameThatIsAboutDueAndOneTickOfTheKernel) {
    // FS-iA6B: 7.7 ms. A repeat at 7 ms would delay the fresh frame until 14 ms, and one less than
    // 4 ms behind it would cost a programming of the clock with each frame.
    const ArrivalClock arrivals = arrivals_each(7700us, at(0ms), 20);
    Schedule schedule = written_on_arrival(7ms, arrivals);
    EXPECT_EQ(schedule.due(), arrivals.latest() + 7750us + 4500us);
}

TEST(FollowSchedule, ARepeatWaitsNoLongerThanWhatWasWrittenIsTrue) {
    const ArrivalClock arrivals = arrivals_each(7700us, at(0ms), 20);
    const Instant latest = arrivals.latest();
    Schedule schedule({.kind = ScheduleKind::follow, .period = 7ms});
    schedule.start(at(0ms));
    schedule.frame_arrived(arrivals);
    schedule.done(latest, true, latest + 9ms);
    EXPECT_EQ(schedule.due(), latest + 9ms);
    schedule.done(latest + 9ms, true, latest + 10ms);
    EXPECT_EQ(schedule.due(), latest + 16ms) << "less than a period is judged ahead";
}

TEST(FollowSchedule, AFrameWaitsForTheNextNoLongerThanWhatWasWrittenIsTrue) {
    // 4 ms in, 7 ms out: the second frame waits for the third, which is due at 44 ms.
    Schedule schedule({.kind = ScheduleKind::follow, .period = 7ms});
    schedule.start(at(0ms));
    schedule.frame_arrived(arrivals_each(4ms, at(0ms), 10));
    schedule.done(at(36ms), true, at(45ms));
    schedule.frame_arrived(arrivals_each(4ms, at(0ms), 11));
    EXPECT_EQ(schedule.due(), at(45ms));
}

TEST(FollowSchedule, AFreshFrameBehindARepeatKeepsTheLeastSpacingAndNotThePeriod) {
    // 7 ms in, 5 ms out; one frame is missing.
    ArrivalClock arrivals = arrivals_each(7ms, at(0ms), 20);
    const Instant latest = arrivals.latest();
    Schedule schedule({.kind = ScheduleKind::follow, .period = 5ms, .least_spacing = 4ms});
    schedule.start(at(0ms));
    schedule.frame_arrived(arrivals);
    schedule.done(latest, true);
    ASSERT_EQ(schedule.due(), latest + 11550us);
    schedule.done(schedule.due(), true);
    arrivals.arrived(latest + 14ms);
    schedule.frame_arrived(arrivals);
    EXPECT_EQ(schedule.due(), latest + 15550us);
}

TEST(FollowSchedule, RepeatsAreAPeriodApartOnceTheInputHasStopped) {
    const ArrivalClock arrivals = arrivals_each(7ms, at(0ms), 20);
    Schedule schedule = written_on_arrival(5ms, arrivals);
    while (schedule.due() < arrivals.latest() + 40ms) {
        schedule.done(schedule.due(), true);
    }
    for (int repeat = 0; repeat < 100; ++repeat) {
        const Instant before = schedule.due();
        schedule.done(before, true);
        ASSERT_EQ(schedule.due(), before + 5ms);
    }
}

TEST(FollowSchedule, ARepeatWaitsLongerForFramesThatComeUnevenly) {
    ArrivalClock arrivals;
    for (int i = 0; i <= 1000; ++i) {
        arrivals.arrived(at(i * 7700us + (i % 2 == 0 ? 0us : 1500us)));
    }
    Schedule schedule = written_on_arrival(7ms, arrivals);
    EXPECT_GT(schedule.due(), arrivals.latest() + 7700us + 1500us);
    EXPECT_LT(schedule.due(), arrivals.latest() + 14ms + 4500us);
}

TEST(FollowSchedule, ASlowInputDoesNotHoldRepeatsBack) {
    const ArrivalClock arrivals = arrivals_each(50ms, at(0ms), 20);
    Schedule schedule = written_on_arrival(7ms, arrivals);
    EXPECT_EQ(schedule.due(), arrivals.latest() + 7ms);
}

TEST(FollowSchedule, SendsTwoOfThreeFramesEach5MsForEverWhereThePeriodIs7Ms) {
    Schedule schedule({.kind = ScheduleKind::follow, .period = 7ms});
    ArrivalClock arrivals;
    schedule.start(at(0ms));
    int writes = 0;
    const auto write_until = [&](Instant until) {
        for (; schedule.due() <= until; ++writes) {
            schedule.done(schedule.due(), true);
        }
    };
    for (int frame = 0; frame < 3000; ++frame) {
        const Instant arrival = at(frame * 5ms);
        write_until(arrival - 1ns);
        arrivals.arrived(arrival);
        schedule.frame_arrived(arrivals);
        write_until(arrival);
    }
    EXPECT_NEAR(writes, 2000, 2);
}

TEST(FollowSchedule, ASilentOutputNeedNotKeepADistanceFromWhatItDidNotWrite) {
    Schedule schedule({.kind = ScheduleKind::follow, .period = 7ms});
    schedule.start(at(0ms));
    schedule.done(at(7ms), false);
    schedule.frame_arrived(arrivals_each(4ms, at(8ms), 1));
    EXPECT_EQ(schedule.due(), at(8ms));
}

TEST(GridSchedule, StaysOnItsGridHoweverLateEachTurnIs) {
    Schedule schedule({.kind = ScheduleKind::grid, .period = 14ms});
    schedule.start(at(3ms));
    for (int point = 0; point < 1000; ++point) {
        ASSERT_EQ(schedule.due(), at(3ms + point * 14ms));
        schedule.done(schedule.due() + (point % 13) * 1ms, true);
    }
    EXPECT_EQ(schedule.overruns(), 0U);
}

TEST(GridSchedule, SkipsWholePeriodsThatWereMissedAndCountsThem) {
    Schedule schedule({.kind = ScheduleKind::grid, .period = 14ms});
    schedule.start(at(0ms));
    schedule.done(at(45ms), true);
    EXPECT_EQ(schedule.due(), at(56ms));
    EXPECT_EQ(schedule.overruns(), 3U);
}

TEST(GridSchedule, ATurnThatComesWhenTheNextIsDueIsTheOnlyOne) {
    Schedule schedule({.kind = ScheduleKind::grid, .period = 14ms});
    schedule.start(at(0ms));
    schedule.done(at(14ms), true);
    EXPECT_EQ(schedule.due(), at(28ms));
    EXPECT_EQ(schedule.overruns(), 1U);
}

TEST(GridSchedule, AFreeGridIsNotMovedByArrivals) {
    Schedule schedule({.kind = ScheduleKind::grid, .period = 14ms});
    schedule.start(at(0ms));
    schedule.frame_arrived(arrivals_each(7700us, at(1ms), 20));
    schedule.done(at(0ms), true);
    EXPECT_EQ(schedule.due(), at(14ms));
}

class LockedGrid : public testing::TestWithParam<Duration> {};

TEST_P(LockedGrid, ComesToStandJustBehindTheArrivalsWithAnEvenCadence) {
    const Duration interval = GetParam();
    Schedule schedule({.kind = ScheduleKind::grid, .period = 14ms, .phase = Phase::locked});
    ArrivalClock arrivals;
    Instant next_arrival = at(1ms);
    schedule.start(at(0ms));
    Instant before{};
    for (int point = 0; point < 2000; ++point) {
        while (next_arrival <= schedule.due()) {
            arrivals.arrived(next_arrival);
            schedule.frame_arrived(arrivals);
            next_arrival += interval;
        }
        const Instant now = schedule.due();
        if (point > 1000) {
            ASSERT_LE(now - arrivals.latest(), 400us) << "point " << point;
            ASSERT_GE(now - before, 14ms - 140us);
            ASSERT_LE(now - before, 14ms + interval);
        }
        before = now;
        schedule.done(now, true);
    }
}

INSTANTIATE_TEST_SUITE_P(Receivers, LockedGrid,
                         testing::Values(Duration(4ms), Duration(7ms), Duration(7700us),
                                         Duration(9ms), Duration(14ms), Duration(13998us),
                                         Duration(20ms)));

/// A settled locked grid of 7 ms with a receiver of 7.7 ms. Every 50th frame came late by `late`.
struct LockedWriter {
    Schedule schedule{{.kind = ScheduleKind::grid, .period = 7ms, .phase = Phase::locked}};
    ArrivalClock arrivals;
    int frames = 0;
    Instant latest_write{};

    explicit LockedWriter(Duration late = 0us) {
        schedule.start(at(0ms));
        for (int i = 0; i < 1000; ++i) {
            write(i % 50 == 0 ? late : Duration(0us));
        }
    }
    /// Handles one input frame and the writes up to the one that should carry it. Returns the age
    /// of the newest values in the last write.
    Duration write(Duration late) {
        const Instant arrival = at(1ms + frames * 7700us + late);
        const Instant next_arrival = at(1ms + (frames + 1) * 7700us);
        ++frames;
        Duration age{};
        bool arrived = false;
        while (schedule.due() < next_arrival || !arrived) {
            if (!arrived && arrival <= schedule.due()) {
                arrived = true;
                arrivals.arrived(arrival);
                schedule.frame_arrived(arrivals);
                continue;
            }
            latest_write = schedule.due();
            age = latest_write - arrivals.latest();
            schedule.done(latest_write, true);
        }
        return age;
    }
};

TEST(LockedGridSchedule, StandsATwentiethOfAMillisecondBehindFramesThatComeOnTheBeat) {
    LockedWriter writer;
    for (int i = 0; i < 100; ++i) {
        EXPECT_NEAR(static_cast<double>(writer.write(0us).count()), 50e3, 5e3);
    }
}

TEST(LockedGridSchedule, WaitsAMomentForAFrameThatIsLate) {
    LockedWriter writer;
    EXPECT_EQ(writer.write(400us), 0us);
}

TEST(LockedGridSchedule, IsWrittenWithoutAFrameThatIsLaterThanThat) {
    LockedWriter writer;
    const Instant before = writer.latest_write;
    const Instant missing = writer.arrivals.latest() + 7700us;
    while (writer.schedule.due() < missing + 5ms) {
        writer.latest_write = writer.schedule.due();
        writer.schedule.done(writer.schedule.due(), true);
    }
    EXPECT_NEAR(static_cast<double>((writer.latest_write - before).count()), 7700e3 + 481e3, 10e3);
}

TEST(LockedGridSchedule, OneStallOfTheMachineDoesNotPushTheGridBack) {
    LockedWriter writer;
    writer.write(3ms);
    writer.write(0us);
    EXPECT_LT(writer.write(0us), 250us);
}

TEST(LockedGridSchedule, NeverWritesTwoFramesCloserThanThePeriod) {
    LockedWriter writer(450us);
    Instant before = writer.latest_write;
    for (int i = 0; i < 1000; ++i) {
        writer.write(std::chrono::microseconds(i * 37 % 450));
        EXPECT_GE(writer.latest_write - before, 7ms - 70us);
        before = writer.latest_write;
    }
}

/// The schedule waits for the last frames in vain. What it writes after that is not early.
TEST(LockedGridSchedule, NeverWritesTwoFramesCloserThanThePeriodWhenTheInputStops) {
    Schedule schedule({.kind = ScheduleKind::grid, .period = 7ms, .phase = Phase::locked});
    schedule.start(at(0ms));
    schedule.frame_arrived(arrivals_each(7ms, at(0ms), 20));
    Instant before{};
    for (int point = 0; point < 60; ++point) {
        const Instant due = schedule.due();
        EXPECT_TRUE(point == 0 || due - before >= 7ms - 70us) << point;
        schedule.done(due, true);
        before = due;
    }
}

/// A frame, seconds of noise, and a frame have no rhythm to follow.
TEST(LockedGridSchedule, KeepsItsPeriodWhereALongSilenceLiesBetweenTwoFrames) {
    Schedule schedule({.kind = ScheduleKind::grid, .period = 7ms, .phase = Phase::locked});
    schedule.start(at(0ms));
    ArrivalClock arrivals;
    arrivals.arrived(at(1ms));
    schedule.frame_arrived(arrivals);
    arrivals.arrived(at(3900ms));
    schedule.done(at(3899ms), true);
    schedule.frame_arrived(arrivals);
    for (int point = 0; point < 10; ++point) {
        const Instant due = schedule.due();
        schedule.done(due, true);
        ASSERT_EQ(schedule.due() - due, 7ms);
    }
}

TEST(LockedGridSchedule, GoesOnAtItsPeriodWhenTheInputHasStopped) {
    Schedule schedule({.kind = ScheduleKind::grid, .period = 14ms, .phase = Phase::locked});
    const ArrivalClock arrivals = arrivals_each(7700us, at(0ms), 20);
    schedule.start(at(0ms));
    schedule.frame_arrived(arrivals);
    Instant now = at(1s);
    schedule.done(now, true);
    for (int point = 0; point < 10; ++point) {
        const Instant due = schedule.due();
        schedule.done(due, true);
        ASSERT_EQ(schedule.due() - due, 14ms);
    }
}

TEST(LockedGridSchedule, MakesNoStepShorterThanItsPeriodBehindAnInputOfTheSame) {
    Schedule schedule({.kind = ScheduleKind::grid, .period = 14ms, .phase = Phase::locked});
    ArrivalClock arrivals;
    schedule.start(at(0ms));
    for (int point = 0; point < 500; ++point) {
        ASSERT_EQ(schedule.due(), at(point * 14ms));
        schedule.done(schedule.due(), true);
        arrivals.arrived(at(point * 14ms + 13800us));  // 200 us before the next point
        schedule.frame_arrived(arrivals);
    }
}

/// docs/channels.md, "When an output sends".
TEST(LockedGridSchedule, At20MsServesEverySecondFrameOfAnInputOf14Ms) {
    Schedule schedule({.kind = ScheduleKind::grid, .period = 20ms, .phase = Phase::locked});
    ArrivalClock arrivals;
    schedule.start(at(0ms));
    Instant before{};
    for (int frame = 0; frame < 1000; ++frame) {
        const Instant arrival = at(1ms) + frame * 14ms;
        for (; schedule.due() < arrival; schedule.done(schedule.due(), true)) {
            if (frame > 500) {
                EXPECT_EQ(schedule.due() - before, 28ms);
            }
            before = schedule.due();
        }
        arrivals.arrived(arrival);
        schedule.frame_arrived(arrivals);
    }
}

TEST(ScheduleAfterAReload, WithAShorterPeriodDoesNotWaitForTheOldDeadline) {
    Schedule before({.kind = ScheduleKind::follow, .period = 1s});
    before.start(at(0ms));
    before.frame_arrived(arrivals_each(7ms, at(2ms), 1));
    before.done(at(2ms), true);
    Schedule after({.kind = ScheduleKind::follow, .period = 20ms});
    after.start(at(10ms));
    after.continue_from(before, at(10ms));
    EXPECT_EQ(after.due(), at(22ms));
}

}  // namespace
}  // namespace tribus::test::schedule_test
