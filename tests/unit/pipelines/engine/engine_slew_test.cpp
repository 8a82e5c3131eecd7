#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "tests/unit/pipelines/engine/engine_bench.h"

/// A channel with a limited rate of change, in the frames of an output that writes every 10 ms.
namespace tribus::test::serial::engine_slew_test {
namespace {

/// 100 us/s is 1 us in 10 ms: 1.6 raw steps.
constexpr double kSlow = 100;
constexpr int kSlowStep = 2;

std::vector<ChannelRule> slow_first_channel() {
    return {{.output = 0, .source = FromChannel{0}, .slew_us_per_second = kSlow}};
}

/// The largest raw step of channel 1 between two frames that were both written after `from`.
int largest_step(const Bench& bench, Instant from, std::size_t output = 0) {
    int largest = 0;
    const std::vector<Seen>& seen = bench.seen(output);
    for (std::size_t i = 1; i < seen.size(); ++i) {
        const int step = std::abs(seen[i].frame.raw[0] - seen[i - 1].frame.raw[0]);
        largest = seen[i - 1].at >= from ? std::max(largest, step) : largest;
    }
    return largest;
}

/// SBUS frames, which have all channels.
void stick(Bench& bench, std::size_t input, Instant from, Instant until, int first,
           bool failsafe = false) {
    for (Instant when = from; when < until; when += 8ms) {
        bench.sbus(input, when, us(first), failsafe, failsafe);
    }
}

/// The stick goes from 1500 to 2000 us, the link is lost for so long, and comes back.
void lose_for(Bench& bench, Duration loss) {
    stick(bench, 0, at(1ms), at(1s), 1500);
    stick(bench, 0, at(1s), at(1500ms), 2000);
    stick(bench, 0, at(1500ms) + loss, at(2500ms) + loss, 2000);
    bench.said(at(2500ms) + loss);
}

TEST(SlewOfAnOutput, DoesNotMakeUpForTheTimeInWhichValuesWereHeld) {
    OutputSettings output = sbus_output({0}, {.hold = 10s});
    output.channels = slow_first_channel();
    Bench bench(list(sbus_input()), list(std::move(output)));
    lose_for(bench, 5s);
    EXPECT_LE(largest_step(bench, at(1s)), kSlowStep);
    EXPECT_NEAR(bench.said(at(7500ms)).raw[0], raw_of(1659), 4) << "it goes on where it was held";
}

TEST(SlewOfAnOutput, MovesNoFasterInTheFirstFrameAfterSilenceThanSinceTheLastOne) {
    OutputSettings output =
        sbus_output({0}, {.hold = 0ms, .action = FailsafeAction::silence, .recover = 0ms});
    output.channels = slow_first_channel();
    Bench bench(list(sbus_input()), list(std::move(output)));
    lose_for(bench, 300ms);
    const auto first =
        std::ranges::find_if(bench.seen(), [](const Seen& seen) { return seen.at > at(1700ms); });
    const double silent_s = std::chrono::duration<double>(first->at - (first - 1)->at).count();
    EXPECT_GT(silent_s, 0.15);
    EXPECT_NEAR(first->frame.raw[0] - (first - 1)->frame.raw[0], kSlow * silent_s * 8 / 5, 1);
}

TEST(SlewOfAnOutput, GoesOnFromWhatWasHeldAlthoughReleaseWhenWasWaitedFor) {
    OutputSettings output =
        sbus_output({0}, {.hold = 0ms,
                          .action = FailsafeAction::hold,
                          .recover = 0ms,
                          .release_when = ValueRule{.channel = 2, .below = us(1050)}});
    output.channels = slow_first_channel();
    Bench bench(list(ibus_input()), list(std::move(output)));
    const auto sticks = [&](Duration from, Duration until, int first, int third) {
        for (Duration when = from; when < until; when += 8ms) {
            bench.ibus(0, at(when), us(first), us(third));
        }
    };
    sticks(1ms, 1s, 1500, 1000);
    sticks(2s, 4s, 2000, 1500);
    EXPECT_TRUE(bench.said(at(4s)).failsafe);
    sticks(4001ms, 5s, 2000, 1000);
    EXPECT_FALSE(bench.said(at(5s)).failsafe);
    EXPECT_LE(largest_step(bench, at(100ms)), kSlowStep);
}

/// The changeover is slower than the slew, so the channel lags behind what the slew allows.
TEST(SlewOfAnOutput, GoesOnAfterSilenceFromWhatAChangeoverHadReached) {
    OutputSettings output =
        sbus_output({0, 1}, {.hold = 0ms, .action = FailsafeAction::silence, .recover = 0ms});
    output.channels = {{.output = 0, .source = FromChannel{0}, .slew_us_per_second = 1000}};
    output.selection.changeover_us_per_second = 10;
    Bench bench(list(sbus_input(), sbus_input()), list(std::move(output)));
    stick(bench, 0, at(1ms), at(1s), 1200);
    stick(bench, 1, at(3ms), at(2s), 1800);
    const int before = bench.said(at(1890ms)).raw[0];
    EXPECT_LT(before, raw_of(1250));
    stick(bench, 1, at(2010ms), at(2100ms), 1800);
    const auto first =
        std::ranges::find_if(bench.seen(), [](const Seen& seen) { return seen.at > at(2s); });
    const double silent_ms =
        std::chrono::duration<double, std::milli>(first->at - (first - 1)->at).count();
    EXPECT_LE(first->frame.raw[0] - (first - 1)->frame.raw[0], silent_ms * 8 / 5 + 1);
}

TEST(GlideAfterAChangeover, DoesNotSlowPresets) {
    OutputSettings output = sbus_output({0, 1}, {.hold = 0ms, .recover = 0ms});
    output.selection.changeover_us_per_second = 10;
    Bench bench(list(sbus_input(), sbus_input()), list(std::move(output)));
    stick(bench, 0, at(1ms), at(1s), 1000);
    stick(bench, 1, at(3ms), at(1500ms), 2000);
    EXPECT_LT(bench.said(at(1500ms)).raw[0], raw_of(1010)) << "on its way to 2000 us";
    const auto& seen = bench.seen();
    bench.said(at(2s));
    const auto preset = std::ranges::find_if(
        seen, [](const Seen& each) { return each.at > at(1500ms) && each.frame.failsafe; });
    ASSERT_NE(preset, seen.end());
    EXPECT_EQ(preset->frame.raw[0], raw_of(1500));
}

TEST(GlideAfterAChangeover, IsNotLostInHeldValuesByAReloadInFailsafe) {
    const auto with_trim = [](int trim_us) {
        OutputSettings output =
            sbus_output({0, 1}, {.hold = 0ms, .action = FailsafeAction::hold, .recover = 0ms});
        output.channels = {{.output = 4, .source = FromChannel{4}, .trim = us(trim_us)}};
        output.selection.changeover_us_per_second = kSlow;
        return output;
    };
    Bench bench(list(sbus_input(), sbus_input()), list(with_trim(0)));
    stick(bench, 0, at(1ms), at(1s), 1000);
    stick(bench, 1, at(3ms), at(1500ms), 2000);
    bench.said(at(2s));
    Engine next(list(sbus_input(), sbus_input()), list(with_trim(10)));
    EngineCarry carry{.inputs = {{.from = 0}, {.from = 1}},
                      .outputs = {{.from = 0, .same_schedule = true}},
                      .nodes = {}};
    bench.loop().run_until(at(2s));
    next.start(at(2s));
    next.continue_from(bench.engine(), carry, at(2s));
    bench.loop().go_on_with(next, nullptr, at(2s));
    bench.said(at(3s));
    EXPECT_LE(largest_step(bench, at(500ms)), kSlowStep);
}

/// The slew starts at the preset, 988 us, so the first frames would fulfil it.
TEST(ReleaseWhen, WaitsForTheStickAlthoughItsChannelComesSlowlyFromALowPreset) {
    OutputSettings output =
        sbus_output({0}, {.release_when = ValueRule{.channel = 2, .below = us(1050)}});
    output.channels = {{.output = 2, .source = FromChannel{2}, .slew_us_per_second = kSlow}};
    Bench bench(list(ibus_input()), list(std::move(output)));
    for (Duration when = 1ms; when < 2s; when += 8ms) {
        bench.ibus(0, at(when), us(1500), us(2000));
    }
    EXPECT_TRUE(bench.said(at(2s)).failsafe);
    EXPECT_EQ(bench.engine().outputs()[0].wait(at(2s), bench.engine().inputs()).pulse, us(2000));
    for (Duration when = 2001ms; when < 2100ms; when += 8ms) {
        bench.ibus(0, at(when), us(1500), us(1000));
    }
    EXPECT_FALSE(bench.said(at(2100ms)).failsafe);
}

/// Frames of an input whose map slows the third channel.
InputSettings slow_throttle_input() {
    InputSettings input = ibus_input();
    input.channels = {{.output = 2, .source = FromChannel{2}, .slew_us_per_second = kSlow}};
    return input;
}
void throttle(Bench& bench, std::size_t input, Duration from, Duration until, int third) {
    for (Duration when = from; when < until; when += 8ms) {
        bench.ibus(input, at(when), us(1500), us(third));
    }
}
OutputSettings output_with_release(std::vector<std::size_t> inputs, int below) {
    return sbus_output(std::move(inputs),
                       {.hold = 0ms,
                        .recover = 500ms,
                        .release_when = ValueRule{.channel = 2, .below = us(below)}});
}

/// The channel has come to 1050 us when the input has recovered.
TEST(ReleaseWhen, WaitsForTheStickAlthoughTheMapOfTheInputSlowsItsChannel) {
    Bench bench(list(slow_throttle_input()), list(output_with_release({0}, 1100)));
    throttle(bench, 0, 1ms, 3s, 1000);
    EXPECT_FALSE(bench.said(at(3s)).failsafe);
    throttle(bench, 0, 4s, 4700ms, 2000);
    EXPECT_TRUE(bench.said(at(4700ms)).failsafe);
    EXPECT_EQ(bench.engine().outputs()[0].wait(at(4700ms), bench.engine().inputs()).pulse,
              us(2000));
    throttle(bench, 0, 4700ms, 4800ms, 1000);
    EXPECT_FALSE(bench.said(at(4800ms)).failsafe);
}

TEST(ReleaseWhen, WaitsForTheSticksOfAllThatVoteWhereTheirMapsSlowTheChannel) {
    OutputSettings output = output_with_release({0, 1}, 1100);
    output.selection.mode = SelectionMode::median;
    Bench bench(list(slow_throttle_input(), slow_throttle_input()), list(std::move(output)));
    const auto both = [&](Duration from, Duration until, int first, int second) {
        for (Duration when = from; when < until; when += 8ms) {
            throttle(bench, 0, when, when + 1ms, first);
            throttle(bench, 1, when, when + 1ms, second);
        }
    };
    both(1ms, 3s, 1000, 1000);
    EXPECT_FALSE(bench.said(at(3s)).failsafe);
    both(4s, 4700ms, 1000, 2000);
    EXPECT_TRUE(bench.said(at(4700ms)).failsafe);
    both(4700ms, 4800ms, 1000, 1000);
    EXPECT_FALSE(bench.said(at(4800ms)).failsafe);
}

/// The slew starts at the preset, 988 us, in each frame, so it never comes above 1400 us.
TEST(ReleaseWhen, IsFulfilledByTheStickAloneWhereASlewStartsAtAPresetBeyondIt) {
    OutputSettings output = sbus_output(
        {0}, {.recover = 500ms,
              .release_when = ValueRule{.channel = 2, .between = PulseRange{us(1400), us(1600)}}});
    output.channels = {{.output = 2, .source = FromChannel{2}, .slew_us_per_second = kSlow}};
    Bench bench(list(ibus_input()), list(std::move(output)));
    throttle(bench, 0, 1ms, 2s, 1700);
    EXPECT_TRUE(bench.said(at(2s)).failsafe);
    throttle(bench, 0, 2s, 2100ms, 1500);
    EXPECT_FALSE(bench.said(at(2100ms)).failsafe);
    EXPECT_NEAR(bench.said(at(2100ms)).raw[2], raw_of(998), 20) << "it goes on from the preset";
}

/// The stick is there at once, the channel of the input comes to it slowly.
TEST(ReleaseWhen, WaitsForTheChannelOfTheInputWhateverThePresetIs) {
    OutputSettings output = sbus_output(
        {0}, {.hold = 0ms,
              .recover = 100ms,
              .release_when = ValueRule{.channel = 2, .between = PulseRange{us(1400), us(1600)}}});
    Bench bench(list(slow_throttle_input()), list(std::move(output)));
    throttle(bench, 0, 1ms, 1s, 1700);
    throttle(bench, 0, 1s, 1500ms, 1500);
    EXPECT_TRUE(bench.said(at(1500ms)).failsafe);
    throttle(bench, 0, 1500ms, 2200ms, 1500);
    EXPECT_FALSE(bench.said(at(2200ms)).failsafe);
}

TEST(SlewOfAnInput, DoesNotMakeUpForTheTimeOfALoss) {
    InputSettings input = sbus_input();
    input.channels = slow_first_channel();
    Bench bench(list(std::move(input)), list(sbus_output({0}, {.hold = 10s})));
    lose_for(bench, 5s);
    EXPECT_LE(largest_step(bench, at(1s)), kSlowStep);
    EXPECT_NEAR(bench.engine().inputs()[0].control().channel_or(0, {}).microseconds(), 1659, 2);
}

/// Frames that say failsafe are no loss of bytes, but the output holds values all the same.
TEST(SlewOfAnInput, RestsWhileItsFramesSayFailsafe) {
    InputSettings input = sbus_input();
    input.channels = slow_first_channel();
    Bench bench(list(std::move(input)), list(sbus_output({0}, {.hold = 10s})));
    stick(bench, 0, at(1ms), at(1s), 1500);
    stick(bench, 0, at(1s), at(1500ms), 2000);
    stick(bench, 0, at(1500ms), at(5s), 2000, true);
    stick(bench, 0, at(5s), at(6s), 2000);
    EXPECT_LE(largest_step(bench, at(1s)), kSlowStep);
}

/// Frames come every 40 ms, the output writes every 10 ms.
TEST(SlewOfAnInput, IsAsEvenInTheFramesOfAFasterOutput) {
    InputSettings input = sbus_input();
    input.channels = slow_first_channel();
    Bench bench(list(std::move(input)), list(sbus_output({0})));
    for (Instant when = at(1ms); when < at(6s); when += 40ms) {
        bench.sbus(0, when, us(when < at(1s) ? 1500 : 2000), false, false);
    }
    EXPECT_EQ(bench.said(at(990ms)).raw[0], raw_of(1500));
    EXPECT_NEAR(bench.said(at(5s)).raw[0], raw_of(1900), 8);
    EXPECT_LE(largest_step(bench, at(900ms)), kSlowStep);
}

TEST(SlewOfAnInput, IsKeptByAnOutputThatLostTheInputBeforeAnotherOutputDid) {
    InputSettings input = sbus_input();
    input.channels = slow_first_channel();
    OutputSettings patient = sbus_output({0});
    patient.schedule.period = 50ms;
    Bench bench(list(std::move(input)), list(sbus_output({0}), std::move(patient)));
    for (Instant when = at(1ms); when < at(6s); when += 90ms) {
        bench.sbus(0, when, us(when < at(1s) ? 1500 : 2000), false, false);
    }
    bench.said(at(6s));
    EXPECT_LE(largest_step(bench, at(900ms), 0), kSlowStep);
    EXPECT_LE(largest_step(bench, at(900ms), 1), 5 * kSlowStep);
}

TEST(SlewOfAnInput, DoesNotSlowAnotherInput) {
    InputSettings slow = sbus_input();
    slow.channels = slow_first_channel();
    Bench bench(list(std::move(slow), sbus_input()), list(sbus_output({0, 1})));
    stick(bench, 0, at(1ms), at(500ms), 1000);
    stick(bench, 1, at(2ms), at(1s), 1800);
    EXPECT_EQ(bench.said(at(1s)).raw[0], raw_of(1800));
    stick(bench, 1, at(1001ms), at(1100ms), 1200);
    EXPECT_EQ(bench.said(at(1100ms)).raw[0], raw_of(1200));
}

TEST(GlideAfterAChangeover, DoesNotMakeUpForTheTimeInWhichValuesWereHeld) {
    for (const auto& [hold, loss] :
         {std::pair(Duration(300ms), Duration(350ms)), std::pair(Duration(10s), Duration(5s))}) {
        OutputSettings output = sbus_output({0, 1}, {.hold = hold});
        output.selection.changeover_us_per_second = kSlow;
        Bench bench(list(sbus_input(), sbus_input()), list(std::move(output)));
        stick(bench, 0, at(1ms), at(1500ms), 1000);
        stick(bench, 1, at(3ms), at(2500ms), 2000);
        stick(bench, 1, at(2500ms) + loss, at(4500ms) + loss, 2000);
        bench.said(at(4500ms) + loss);
        EXPECT_LE(largest_step(bench, at(1s)), kSlowStep) << loss / 1ms;
    }
}

TEST(FailsafeSlew, DoesNotMakeUpOnItsWayBackForTheTimeInWhichValuesWereHeld) {
    Bench bench(list(sbus_input()), list(sbus_output({0}, {.slew_us_per_second = kSlow})));
    stick(bench, 0, at(1ms), at(1200ms), 1900);
    stick(bench, 0, at(6s), at(7s), 1900);
    stick(bench, 0, at(7350ms), at(9s), 1900);
    bench.said(at(9s));
    EXPECT_LE(largest_step(bench, at(600ms)), kSlowStep);
}

/// A changeover without a limit of its own does not end the one that leads back from the presets.
TEST(FailsafeSlew, GoesOnOverAChangeoverOnItsWayBack) {
    Bench bench(list(sbus_input(), sbus_input()),
                list(sbus_output({0, 1}, {.slew_us_per_second = kSlow})));
    bench.said(at(1s));
    stick(bench, 0, at(1001ms), at(2s), 1900);
    stick(bench, 1, at(1003ms), at(4s), 2000);
    bench.said(at(4s));
    EXPECT_EQ(bench.engine().outputs()[0].counts().changeovers, 1U);
    EXPECT_LE(largest_step(bench, at(0ms)), kSlowStep);
}

}  // namespace
}  // namespace tribus::test::serial::engine_slew_test
