#include <gtest/gtest.h>

#include "tests/unit/pipelines/engine/engine_bench.h"

/// GPIO lines as inputs and outputs of an engine. The receiver sends every 8 ms, the SBUS output
/// has a period of 10 ms, the timeout is 100 ms, and failsafe has its defaults: hold 300 ms,
/// recover 500 ms.
namespace tribus::test::engine_lines_test {
namespace {

using namespace serial;

constexpr std::uint32_t kFirst = 1;
constexpr std::uint32_t kSecond = 2;

LineTask line(LineRole role, std::vector<std::size_t> outputs = {0}) {
    return {.role = role, .outputs = std::move(outputs)};
}
LineTask select_line(std::size_t input) {
    return {.role = LineRole::select, .input = input};
}

/// One receiver and one output.
Bench one_output(std::vector<LineTask> lines, FailsafeSettings failsafe = {}) {
    return {list(ibus_input()), list(sbus_output({0}, failsafe)), std::move(lines)};
}
/// Two receivers, each with an output of its own.
Bench two_outputs(std::vector<LineTask> lines) {
    return {list(ibus_input(), ibus_input()), list(sbus_output({0}), sbus_output({1})),
            std::move(lines)};
}
/// Two receivers with one output. The second sends 1700 us.
Bench two_receivers(std::vector<LineTask> lines) {
    return {list(ibus_input(), ibus_input()), list(sbus_output({0, 1})), std::move(lines)};
}

bool is_on(Bench& bench, Instant when, std::uint32_t line = kFirst) {
    bench.loop().run_until(when);
    return (bench.engine().shown_on_lines().on & line) != 0;
}
bool blinks(Bench& bench, Instant when, std::uint32_t line = kFirst) {
    bench.loop().run_until(when);
    return (bench.engine().shown_on_lines().blinking & line) != 0;
}
bool is_off(Bench& bench, Instant when, std::uint32_t line = kFirst) {
    return !is_on(bench, when, line) && !blinks(bench, when, line);
}

LineLevels only(std::uint32_t active) {
    return {active, UINT32_MAX};
}

TEST(LinkLamp, IsOffInFailsafeOnUnderControlAndBlinksWhileValuesAreHeld) {
    Bench bench = one_output({line(LineRole::link)});
    EXPECT_TRUE(is_off(bench, at(0ms)));
    bench.ibus_run(0, at(5ms), at(1000ms), us(1200));
    EXPECT_TRUE(is_on(bench, at(1000ms)));
    EXPECT_TRUE(is_on(bench, at(1080ms)));
    EXPECT_TRUE(blinks(bench, at(1150ms)));
    EXPECT_FALSE(is_on(bench, at(1150ms)));
    EXPECT_TRUE(is_off(bench, at(1500ms)));
}

TEST(LinkLamp, BlinksWhileTheReceiverMarksItsFramesLost) {
    Bench bench({list(sbus_input())}, list(sbus_output({0})), {line(LineRole::link)});
    for (int i = 0; i < 20; ++i) {
        bench.sbus(0, at(5ms + i * 10ms), us(1200), false, false);
    }
    EXPECT_TRUE(is_on(bench, at(200ms)));
    for (int i = 20; i < 24; ++i) {
        bench.sbus(0, at(5ms + i * 10ms), us(1200), true, false);
    }
    EXPECT_TRUE(blinks(bench, at(240ms)));
}

TEST(LinkLamp, ShowsTheWorstOfItsOutputs) {
    Bench bench = two_outputs({line(LineRole::link, {0, 1}), line(LineRole::link, {0})});
    bench.ibus_run(0, at(5ms), at(500ms), us(1200));
    EXPECT_TRUE(is_off(bench, at(500ms), kFirst));
    EXPECT_TRUE(is_on(bench, at(500ms), kSecond));
}

TEST(FailsafeAlarm, IsOnInFailsafeOnly) {
    Bench bench = one_output({line(LineRole::failsafe)});
    EXPECT_TRUE(is_on(bench, at(0ms)));
    bench.ibus_run(0, at(5ms), at(1000ms), us(1200));
    EXPECT_TRUE(is_off(bench, at(1000ms)));
    EXPECT_TRUE(is_off(bench, at(1150ms)));
    EXPECT_TRUE(is_on(bench, at(1500ms)));
}

TEST(FailsafeAlarm, IsOnForAnyOfItsOutputs) {
    Bench bench = two_outputs({line(LineRole::failsafe, {0, 1}), line(LineRole::failsafe, {0})});
    bench.ibus_run(0, at(5ms), at(500ms), us(1200));
    EXPECT_TRUE(is_on(bench, at(500ms), kFirst));
    EXPECT_TRUE(is_off(bench, at(500ms), kSecond));
}

TEST(InverterLine, IsOnFromTheStart) {
    Bench bench = one_output({line(LineRole::inverter, {})});
    EXPECT_TRUE(is_on(bench, at(0ms)));
}

TEST(ForceFailsafe, PutsItsOutputsIntoFailsafeWithinOnePeriodAndLetsGoAsAfterALoss) {
    Bench bench = two_outputs({line(LineRole::force_failsafe)});
    for (const std::size_t input : {0U, 1U}) {
        bench.ibus_run(input, at(5ms), at(5ms) + 1ns, us(1200));
    }
    for (Instant now = at(13ms); now < at(995ms); now += 8ms) {
        bench.ibus(0, now, us(1200));
        bench.ibus(1, now, us(1200));
    }
    EXPECT_FALSE(bench.said(at(995ms)).failsafe);
    bench.engine().set_lines(only(kFirst), at(996ms));
    EXPECT_TRUE(bench.said(at(1006ms)).failsafe);
    EXPECT_FALSE(bench.said(at(1006ms), 1).failsafe);
    bench.engine().set_lines(only(0), at(1007ms));
    for (Instant now = at(1008ms); now < at(1600ms); now += 8ms) {
        bench.ibus(0, now, us(1200));
        bench.ibus(1, now, us(1200));
    }
    EXPECT_TRUE(bench.said(at(1500ms)).failsafe);
    EXPECT_FALSE(bench.said(at(1520ms)).failsafe);
}

TEST(ForceFailsafe, IsInForceWhileItsLineCannotBeRead) {
    Bench bench = one_output({line(LineRole::force_failsafe)});
    bench.ibus_run(0, at(5ms), at(300ms), us(1200));
    EXPECT_FALSE(bench.said(at(300ms)).failsafe);
    bench.engine().set_lines({0, 0}, at(301ms));
    EXPECT_TRUE(bench.said(at(311ms)).failsafe);
}

TEST(ForceFailsafe, IsInForceWhileEitherOfTwoLinesIs) {
    Bench bench = one_output({line(LineRole::force_failsafe), line(LineRole::force_failsafe)}, {});
    bench.engine().set_lines(only(kFirst | kSecond), at(0ms));
    bench.engine().set_lines(only(kSecond), at(1ms));
    bench.ibus_run(0, at(5ms), at(1000ms), us(1200));
    EXPECT_TRUE(bench.said(at(1000ms)).failsafe);
}

TEST(ForceFailsafe, IsInForceFromTheFirstFrameIfItIsActiveAtTheStart) {
    Bench bench = one_output({line(LineRole::force_failsafe)}, {.recover = 0ms});
    bench.engine().set_lines(only(kFirst), at(0ms));
    bench.ibus_run(0, at(5ms), at(1000ms), us(1200));
    bench.said(at(1000ms));
    for (const Seen& seen : bench.seen()) {
        EXPECT_TRUE(seen.frame.failsafe);
    }
}

TEST(SelectLine, PicksItsInputWhileItIsActive) {
    Bench bench = two_receivers({select_line(1)});
    const auto both = [&](Instant from, Instant until) {
        for (Instant now = from; now < until; now += 8ms) {
            bench.ibus(0, now, us(1200));
            bench.ibus(1, now, us(1700));
        }
    };
    both(at(5ms), at(800ms));
    EXPECT_EQ(bench.said(at(800ms)).raw[0], raw_of(1200));
    bench.engine().set_lines(only(kFirst), at(801ms));
    EXPECT_EQ(bench.said(at(811ms)).raw[0], raw_of(1700));
    both(at(812ms), at(900ms));
    bench.engine().set_lines(only(0), at(901ms));
    EXPECT_EQ(bench.said(at(911ms)).raw[0], raw_of(1200));
}

TEST(SelectLine, FirstOfSeveralActiveOnesCounts) {
    Bench bench = two_receivers({select_line(1), select_line(0)});
    for (Instant now = at(5ms); now < at(800ms); now += 8ms) {
        bench.ibus(0, now, us(1200));
        bench.ibus(1, now, us(1700));
    }
    bench.engine().set_lines(only(kFirst | kSecond), at(801ms));
    EXPECT_EQ(bench.said(at(811ms)).raw[0], raw_of(1700));
}

TEST(SelectLine, ThatCannotBeReadPicksNothing) {
    Bench bench = two_receivers({select_line(1)});
    for (Instant now = at(5ms); now < at(800ms); now += 8ms) {
        bench.ibus(0, now, us(1200));
        bench.ibus(1, now, us(1700));
    }
    bench.engine().set_lines(only(kFirst), at(801ms));
    bench.engine().set_lines({0, 0}, at(802ms));
    EXPECT_EQ(bench.said(at(812ms)).raw[0], raw_of(1200));
}

/// Channel 5 of the output comes from the first line.
Bench with_button() {
    OutputSettings output = sbus_output({0});
    output.channels.push_back({.output = 4, .source = FromLine{0}});
    return {list(ibus_input()), list(std::move(output)), {line(LineRole::button, {})}};
}

TEST(Button, MakesAChannelThatIsHighWhileItIsActive) {
    Bench bench = with_button();
    bench.ibus_run(0, at(5ms), at(800ms), us(1200));
    EXPECT_EQ(bench.said(at(800ms)).raw[4], raw_of(1000));
    bench.engine().set_lines(only(kFirst), at(801ms));
    EXPECT_EQ(bench.said(at(811ms)).raw[4], raw_of(2000));
}

TEST(Button, ThatCannotBeReadIsAnAbsentChannelWhichIsItsPreset) {
    Bench bench = with_button();
    bench.ibus_run(0, at(5ms), at(800ms), us(1200));
    bench.engine().set_lines({0, 0}, at(801ms));
    EXPECT_EQ(bench.said(at(811ms)).raw[4], raw_of(1500));
}

LineTask switch_line(ValueRule rule) {
    return {.role = LineRole::channel_switch, .outputs = {0}, .rule = rule};
}

TEST(SwitchLine, IsOnWhileItsChannelIsInTheRange) {
    Bench bench = one_output({switch_line({.channel = 0, .above = us(1700)}),
                              switch_line({.channel = 0, .below = us(1300)})});
    bench.ibus_run(0, at(5ms), at(700ms), us(1200));
    EXPECT_TRUE(is_off(bench, at(701ms), kFirst));
    EXPECT_TRUE(is_on(bench, at(701ms), kSecond));
    bench.ibus_run(0, at(704ms), at(800ms), us(1800));
    EXPECT_TRUE(is_on(bench, at(801ms), kFirst));
    EXPECT_TRUE(is_off(bench, at(801ms), kSecond));
}

TEST(SwitchLine, GoesByThePresetsInFailsafeForTheyAreWhatIsSent) {
    // Presets of the bench: channel 3 at 988 us, the others at 1500 us.
    Bench bench = one_output({switch_line({.channel = 2, .below = us(1000)}),
                              switch_line({.channel = 0, .above = us(1700)})});
    bench.ibus_run(0, at(5ms), at(700ms), us(1800));
    EXPECT_TRUE(is_off(bench, at(701ms), kFirst));
    EXPECT_TRUE(is_on(bench, at(701ms), kSecond));
    EXPECT_TRUE(is_on(bench, at(1500ms), kFirst));
    EXPECT_TRUE(is_off(bench, at(1500ms), kSecond));
}

TEST(SwitchLine, IsOffWhileTheOutputIsSilent) {
    Bench bench = one_output({switch_line({.channel = 0, .above = us(1700)})},
                             {.action = FailsafeAction::silence});
    bench.ibus_run(0, at(5ms), at(700ms), us(1800));
    EXPECT_TRUE(is_on(bench, at(701ms)));
    EXPECT_TRUE(is_off(bench, at(1500ms)));
}

/// Returns whether the output's latest frame is fresh if it is written `delay` after it was due.
bool fresh_after(Bench& bench, Duration delay) {
    const Output& output = bench.engine().outputs()[0];
    return is_fresh(output, output.latest_due() + delay);
}

TEST(FreshData, IsOfAnInputInControlAndHandedOverWithinHalfAPeriod) {
    Bench bench = one_output({});
    bench.ibus_run(0, at(5ms), at(700ms), us(1200));
    bench.said(at(700ms));
    EXPECT_TRUE(fresh_after(bench, 0ms));
    EXPECT_TRUE(fresh_after(bench, 5ms));
    EXPECT_FALSE(fresh_after(bench, 5ms + 1ns));
}

TEST(FreshData, IsNotWhatIsHeldNorAFailsafe) {
    Bench bench = one_output({});
    bench.said(at(0ms));
    EXPECT_FALSE(fresh_after(bench, 0ms)) << "before the first frame";
    bench.ibus_run(0, at(5ms), at(700ms), us(1200));
    bench.said(at(850ms));
    EXPECT_FALSE(fresh_after(bench, 0ms)) << "held";
    bench.said(at(1500ms));
    EXPECT_FALSE(fresh_after(bench, 0ms)) << "failsafe";
}

TEST(FreshData, IsNotAFailsafeThatIsMeant) {
    Bench bench = one_output({line(LineRole::force_failsafe)});
    bench.ibus_run(0, at(5ms), at(700ms), us(1200));
    bench.engine().set_lines(only(kFirst), at(701ms));
    bench.said(at(711ms));
    EXPECT_FALSE(fresh_after(bench, 0ms));
}

TEST(FreshData, IsNotWhatTheReceiverMarksLost) {
    Bench bench({list(sbus_input())}, list(sbus_output({0})), {});
    for (int i = 0; i < 24; ++i) {
        bench.sbus(0, at(5ms + i * 10ms), us(1200), i >= 20, false);
    }
    bench.said(at(241ms));
    EXPECT_EQ(bench.engine().outputs()[0].stage(), OutputStage::control);
    EXPECT_FALSE(fresh_after(bench, 0ms));
}

}  // namespace
}  // namespace tribus::test::engine_lines_test
