#include <gtest/gtest.h>

#include "tests/unit/pipelines/engine/engine_bench.h"

/// Frames of an output when control begins, passes to another input and returns.
namespace tribus::test::serial::engine_return_test {
namespace {

TEST(ControlThatReturns, LeadsAChannelWithASlewFromItsPreset) {
    OutputSettings output = sbus_output({0}, {.hold = 0ms, .recover = 0ms});
    output.channels = {{.output = 0, .source = FromChannel{0}, .slew_us_per_second = 1000}};
    Bench bench(list(ibus_input()), list(std::move(output)));
    bench.ibus_run(0, at(1ms), at(500ms), us(2000));
    EXPECT_EQ(bench.said(at(1500ms)).raw[0], raw_of(1500));
    bench.ibus(0, at(1505ms), us(2000));
    EXPECT_EQ(bench.said(at(1510ms)).raw[0], raw_of(1510)) << "10 us in 10 ms";
}

TEST(ControlThatReturns, AfterSilenceSaysAtOnceWhatTheSticksSay) {
    Bench bench(list(ibus_input()), list(sbus_output({0}, {.hold = 0ms,
                                                           .action = FailsafeAction::silence,
                                                           .slew_us_per_second = 100,
                                                           .recover = 0ms})));
    bench.ibus_run(0, at(1ms), at(500ms), us(2000));
    bench.ibus(0, at(1505ms), us(1000));
    EXPECT_EQ(bench.said(at(1510ms)).raw[0], raw_of(1000));
}

TEST(ReleaseWhen, IsWaitedForNoLongerWhereTheInputIsLostBeforeItComes) {
    Bench bench(
        list(ibus_input()),
        list(sbus_output({0}, {.release_when = ValueRule{.channel = 2, .below = us(1050)}})));
    bench.ibus_run(0, at(1ms), at(500ms), us(1100));  // the third channel at 1200 us
    bench.said(at(500ms));
    EXPECT_TRUE(bench.engine().outputs()[0].state(at(500ms)).awaits_release);
    bench.said(at(1s));
    EXPECT_FALSE(bench.engine().outputs()[0].state(at(1s)).awaits_release);
}

TEST(ReleaseWhen, IsNotAskedForAfterALossWithinHold) {
    Bench bench(
        list(ibus_input()),
        list(sbus_output({0}, {.release_when = ValueRule{.channel = 0, .below = us(1050)}})));
    bench.ibus_run(0, at(1ms), at(500ms), us(1000));
    bench.ibus_run(0, at(500ms), at(1s), us(1500));
    bench.ibus_run(0, at(1200ms), at(1300ms), us(1500));
    EXPECT_TRUE(bench.said(at(1190ms)).frame_lost);
    EXPECT_FALSE(bench.said(at(1300ms)).frame_lost);
}

TEST(StandbyInput, DoesNotSetTheBeatOfALockedGrid) {
    OutputSettings output = sbus_output({0, 1});
    output.schedule = {.kind = ScheduleKind::grid, .period = 14ms, .phase = Phase::locked};
    Bench bench(list(ibus_input(), ibus_input()), list(std::move(output)));
    Instant latest{};
    for (Instant when = at(1ms); when < at(5s); when += 14ms) {
        bench.ibus(0, when, us(1100));
        latest = when;
        bench.ibus(1, when + 5ms, us(1900));
    }
    bench.said(latest + 13ms);
    EXPECT_LT(bench.seen().back().at - latest, 1ms);
}

TEST(SelectionFreshest, PrefersTheFirstOfTwoThatAreEquallyFresh) {
    OutputSettings output = sbus_output({0, 1});
    output.selection.mode = SelectionMode::freshest;
    Bench bench(list(ibus_input(), ibus_input()), list(std::move(output)));
    bench.ibus(0, at(1ms), us(1100));
    bench.ibus(1, at(1ms), us(1900));
    EXPECT_EQ(bench.said(at(10ms)).raw[0], raw_of(1100));
}

}  // namespace
}  // namespace tribus::test::serial::engine_return_test
