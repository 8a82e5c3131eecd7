#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "tests/unit/pipelines/engine/engine_bench.h"

/// What an output continues with when another engine replaces the running one.
namespace tribus::test::serial::engine_reload_test {
namespace {

OutputCarry all_but_channels() {
    return {.from = 0, .same_channels = false, .same_schedule = true, .same_failsafe = true};
}
OutputCarry everything() {
    OutputCarry carry = all_but_channels();
    carry.same_channels = true;
    return carry;
}

/// Continues in `next`, which has as many inputs. Each is the successor of the one with the same
/// index.
void reload(Bench& bench, Engine& next, Duration when, const OutputCarry& carry = everything(),
            bool same_input_channels = true) {
    bench.said(at(when));
    std::vector<InputCarry> inputs;
    for (std::size_t input = 0; input < next.inputs().size(); ++input) {
        inputs.push_back({.from = input, .same_channels = same_input_channels});
    }
    next.start(at(when));
    next.continue_from(bench.engine(), {.inputs = inputs, .outputs = {carry}, .nodes = {}},
                       at(when));
    bench.loop().go_on_with(next, nullptr, at(when));
}

TEST(ReloadOfAnOutput, LeavesTheRecoveryThatIsDueAfterAForcedFailsafe) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    bench.ibus_run(0, at(1ms), at(1s), us(1100));
    bench.said(at(1s));
    bench.engine().output(0).force_failsafe(true, at(1s));
    bench.ibus_run(0, at(1001ms), at(1200ms), us(1100));
    bench.engine().output(0).force_failsafe(false, at(1200ms));
    bench.ibus_run(0, at(1201ms), at(1300ms), us(1100));
    Engine next(list(ibus_input()), list(sbus_output({0})));
    reload(bench, next, 1300ms);
    bench.ibus_run(0, at(1301ms), at(2s), us(1100));
    EXPECT_TRUE(bench.said(at(1690ms)).failsafe);
    EXPECT_FALSE(bench.said(at(1710ms)).failsafe) << "500 ms after it was let go";
}

/// At 10 us/s, where the change from 1000 to 2000 us would take 100 s. Returns the channel 100 ms
/// after the reload.
int after_a_reload_with(std::optional<double> us_per_second) {
    const auto output = [](std::optional<double> rate) {
        OutputSettings settings = sbus_output({0, 1});
        settings.selection.changeover_us_per_second = rate;
        return settings;
    };
    Bench bench(list(ibus_input(), ibus_input()), list(output(10)));
    for (Duration when = 1ms; when < 2s; when += 7ms) {
        if (when < 1s) {
            bench.ibus(0, at(when), us(1000));
        }
        bench.ibus(1, at(when), us(2000));
    }
    EXPECT_LE(bench.said(at(2s)).raw[0], raw_of(1010));
    Engine next(list(ibus_input(), ibus_input()), list(output(us_per_second)));
    reload(bench, next, 2s);
    bench.ibus_run(1, at(2001ms), at(2100ms), us(2000));
    return bench.said(at(2100ms)).raw[0];
}

TEST(ReloadOfAnOutput, GivesAChangeoverThatIsUnderWayItsNewRate) {
    const int at_1000_us_per_second = after_a_reload_with(1000);
    EXPECT_GT(at_1000_us_per_second, raw_of(1090));
    EXPECT_LT(at_1000_us_per_second, raw_of(1115));
}

TEST(ReloadOfAnOutput, EndsAChangeoverThatTheConfigurationHasNoMore) {
    EXPECT_EQ(after_a_reload_with(std::nullopt), raw_of(2000));
}

TEST(ReloadOfAnOutput, TakesValuesThatAreHeldThroughTheNewMap) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    bench.ibus_run(0, at(1ms), at(500ms), us(1100));
    OutputSettings reversed = sbus_output({0});
    reversed.channels = {{.output = 0, .source = FromChannel{0}, .reverse = true}};
    Engine next(list(ibus_input()), list(std::move(reversed)));
    reload(bench, next, 700ms, all_but_channels());
    const SbusFrame held = bench.said(at(750ms));
    EXPECT_TRUE(held.frame_lost);
    EXPECT_EQ(held.raw[0], raw_of(1900));
}

TEST(ReloadOfAnOutput, BeginsANewSlewWhereItStandsAlthoughTheMapBeforeSaidOtherwise) {
    OutputSettings reversed = sbus_output({0});
    reversed.channels = {{.output = 0, .source = FromChannel{0}, .reverse = true}};
    Bench bench(list(ibus_input()), list(std::move(reversed)));
    bench.ibus_run(0, at(1ms), at(500ms), us(1000));
    OutputSettings slow = sbus_output({0});
    slow.channels = {{.output = 0, .source = FromChannel{0}, .slew_us_per_second = 1000}};
    Engine next(list(ibus_input()), list(std::move(slow)));
    reload(bench, next, 500ms, all_but_channels());
    bench.ibus(0, at(501ms), us(1000));
    EXPECT_EQ(bench.said(at(510ms)).raw[0], raw_of(1990)) << "10 ms after it said 2000 us";
}

TEST(ReloadOfAnOutput, InFailsafeGoesToOtherPresetsAsSlowlyAsItIsTo) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    EXPECT_EQ(bench.said(at(500ms)).raw[0], raw_of(1500));
    OutputSettings other = sbus_output({0});
    other.failsafe.presets[0] = us(2000);
    other.failsafe.slew_us_per_second = 1000;
    Engine next(list(ibus_input()), list(std::move(other)));
    OutputCarry carry = everything();
    carry.same_failsafe = false;
    reload(bench, next, 500ms, carry);
    EXPECT_EQ(bench.said(at(600ms)).raw[0], raw_of(1600));
    EXPECT_EQ(bench.said(at(1500ms)).raw[0], raw_of(2000));
}

TEST(ReloadOfAnInput, BeginsANewSlewOfItsOwnWhereItStands) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    bench.ibus_run(0, at(1ms), at(500ms), us(1000));
    InputSettings slow = ibus_input();
    slow.channels = {
        {.output = 0, .source = FromChannel{0}, .reverse = true, .slew_us_per_second = 1000}};
    Engine next(list(std::move(slow)), list(sbus_output({0})));
    reload(bench, next, 500ms, everything(), false);
    bench.ibus(0, at(510ms), us(1000));
    EXPECT_EQ(bench.said(at(520ms)).raw[0], raw_of(1020)) << "20 ms on its way to 2000 us";
}

TEST(ReloadOfAnOutput, KeepsWhatButtonsSayUntilTheySayOtherwise) {
    const auto with_button = [](int trim) {
        OutputSettings output = sbus_output({0});
        output.channels = {{.output = 4, .source = FromLine{0}, .trim = us(trim)}};
        return output;
    };
    const LineTask button{.role = LineRole::button};
    Bench bench(list(ibus_input()), list(with_button(0)), {button});
    bench.ibus_run(0, at(1ms), at(500ms), us(1100));
    bench.engine().set_lines({.active = 1, .known = 1}, at(500ms));
    Engine next(list(ibus_input()), list(with_button(-100)), {button});
    reload(bench, next, 500ms, all_but_channels());
    bench.ibus(0, at(501ms), us(1100));
    EXPECT_EQ(bench.said(at(510ms)).raw[4], raw_of(1900));
}

TEST(ReloadOfAnOutput, UsesAnOutvotedInputAgainWhereNothingIsVotedOnAnyMore) {
    OutputSettings voting = sbus_output({0, 1, 2});
    voting.selection.mode = SelectionMode::median;
    Bench bench(list(ibus_input(), ibus_input(), ibus_input()), list(std::move(voting)));
    for (Duration when = 1ms; when < 2s; when += 10ms) {
        bench.ibus(0, at(when), us(1900));
        bench.ibus(1, at(when + 1ms), us(1100));
        bench.ibus(2, at(when + 2ms), us(1100));
    }
    EXPECT_TRUE(bench.engine().outputs()[0].selector().outvoted(0));
    Engine next(list(ibus_input(), ibus_input(), ibus_input()), list(sbus_output({0, 1, 2})));
    reload(bench, next, 2s);
    bench.ibus_run(0, at(2001ms), at(3s), us(1900));
    EXPECT_FALSE(bench.said(at(3s)).failsafe) << "the only one that still sends";
    EXPECT_EQ(bench.said(at(3s)).raw[0], raw_of(1900));
}

TEST(ReloadOfAnOutput, ReadsTheHandoverChannelAnewWhereTheInputsToPickAreOthers) {
    const auto picking = [](std::vector<std::size_t> inputs) {
        OutputSettings output = sbus_output(std::move(inputs));
        output.selection.handover = HandoverSettings{.input = 0, .channel = 2};
        return output;
    };
    const auto three = [] { return list(ibus_input(), ibus_input(), ibus_input()); };
    Bench bench(three(), list(picking({0, 1})));
    const auto run = [&](Duration from, Duration until) {
        for (Instant when = at(from); when < at(until); when += 8ms) {
            bench.ibus(0, when, us(1100), us(1670));  // just in the last third of three
            bench.ibus(1, when + 1ms, us(1200));
            bench.ibus(2, when + 2ms, us(1300));
        }
    };
    run(1ms, 500ms);
    EXPECT_EQ(bench.said(at(505ms)).raw[0], raw_of(1200));
    Engine next(three(), list(picking({0, 1, 2})));
    reload(bench, next, 506ms);
    run(507ms, 600ms);
    EXPECT_EQ(bench.said(at(610ms)).raw[0], raw_of(1300));
}

}  // namespace
}  // namespace tribus::test::serial::engine_reload_test
