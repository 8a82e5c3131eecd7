#include "pipelines/engine/engine.h"

#include <cstdint>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/pipelines/engine/engine_bench.h"

/// Which of several inputs an output follows, how it changes to another one, and how it returns.
namespace tribus::test::serial::engine_selection_test {
namespace {

OutputSettings output_with(SelectionMode mode, std::size_t inputs) {
    OutputSettings settings = sbus_output({});
    settings.selection.mode = mode;
    for (std::size_t input = 0; input < inputs; ++input) {
        settings.selection.inputs.push_back(input);
    }
    return settings;
}

/// Several inputs at the same time: frames every 8 ms, 1 ms apart, until `until`. Values by input,
/// 0 for no frame.
class Inputs {
  public:
    explicit Inputs(Bench& bench) : bench_(bench) {}
    void run(Duration until, std::vector<int> values) {
        for (; next_ < at(until); next_ += 8ms) {
            for (std::size_t input = 0; input < values.size(); ++input) {
                if (values[input] != 0) {
                    bench_.ibus(input, next_ + static_cast<std::int64_t>(input) * 1ms,
                                us(values[input]));
                }
            }
        }
    }

  private:
    Bench& bench_;
    Instant next_ = at(1ms);
};

/// Returns the first channel of the output at `when`, in whole microseconds.
int first_channel(Bench& bench, Duration when) {
    return 880 + bench.said(at(when)).raw[0] * 5 / 8;
}

TEST(SelectionSticky, StaysWithTheBackupAfterTheMainInputIsBack) {
    Bench bench(list(ibus_input(), ibus_input()), list(output_with(SelectionMode::sticky, 2)));
    Inputs inputs(bench);
    inputs.run(500ms, {1100, 1900});
    EXPECT_EQ(first_channel(bench, 500ms), 1100);
    inputs.run(1s, {0, 1900});
    EXPECT_EQ(first_channel(bench, 1s), 1900);
    inputs.run(5s, {1100, 1900});
    EXPECT_EQ(first_channel(bench, 5s), 1900);
    inputs.run(6s, {1100, 0});
    EXPECT_EQ(first_channel(bench, 6s), 1100);
}

TEST(SelectionFreshest, TakesTheYoungestValuesWhoeverSendsThem) {
    Bench bench(list(ibus_input(), ibus_input()), list(output_with(SelectionMode::freshest, 2)));
    bench.ibus(0, at(1ms), us(1100));
    bench.ibus(1, at(2ms), us(1900));
    EXPECT_EQ(first_channel(bench, 10ms), 1900);
    bench.ibus(0, at(12ms), us(1100));
    EXPECT_EQ(first_channel(bench, 20ms), 1100);
}

TEST(SelectionFreshest, NeverChangesOverSoThatNoMovementIsSlowed) {
    OutputSettings output = output_with(SelectionMode::freshest, 2);
    output.selection.changeover_us_per_second = 100;
    Bench bench(list(ibus_input(), ibus_input()), list(std::move(output)));
    bench.ibus(0, at(1ms), us(1100));
    EXPECT_EQ(first_channel(bench, 10ms), 1100);
    bench.ibus(1, at(12ms), us(1900));
    EXPECT_EQ(first_channel(bench, 20ms), 1900);
}

TEST(SelectionFreshest, AMissingFrameCostsNothingWhileAnotherInputHasOne) {
    Bench bench(list(ibus_input(), ibus_input()), list(output_with(SelectionMode::freshest, 2)));
    Inputs inputs(bench);
    inputs.run(500ms, {1100, 1100});
    inputs.run(580ms, {0, 1200});
    EXPECT_EQ(first_channel(bench, 520ms), 1200);
}

TEST(SelectionMedian, ASingleLiarChangesNothing) {
    Bench bench(list(ibus_input(), ibus_input(), ibus_input()),
                list(output_with(SelectionMode::median, 3)));
    Inputs inputs(bench);
    inputs.run(500ms, {1495, 1500, 1510});
    EXPECT_EQ(first_channel(bench, 500ms), 1500);
    inputs.run(600ms, {1495, 1500, 2000});
    EXPECT_EQ(first_channel(bench, 600ms), 1500);
    inputs.run(700ms, {1000, 1500, 1510});
    EXPECT_EQ(first_channel(bench, 700ms), 1500);
}

TEST(SelectionMedian, IsBetweenTwoThatAgreeAndThePreferredOfTwoThatDoNot) {
    Bench bench(list(ibus_input(), ibus_input(), ibus_input()),
                list(output_with(SelectionMode::median, 3)));
    Inputs inputs(bench);
    inputs.run(500ms, {1500, 1520, 0});
    EXPECT_EQ(first_channel(bench, 500ms), 1510);
    inputs.run(600ms, {1500, 1700, 0});
    EXPECT_EQ(first_channel(bench, 600ms), 1500);
}

TEST(SelectionMedian, ReportsALiarAfterHalfASecondAndTakesItBackWhenItAgrees) {
    Bench bench(list(ibus_input(), ibus_input(), ibus_input()),
                list(output_with(SelectionMode::median, 3)));
    const InputSelector& selector = bench.engine().outputs()[0].selector();
    Inputs inputs(bench);
    inputs.run(1s, {1500, 1500, 1500});
    inputs.run(1450ms, {1500, 1500, 1551});
    bench.said(at(1450ms));
    EXPECT_FALSE(selector.outvoted(2));
    inputs.run(1600ms, {1500, 1500, 1551});
    bench.said(at(1600ms));
    EXPECT_TRUE(selector.outvoted(2));
    EXPECT_EQ(selector.outvoted_count(), 1U);
    inputs.run(3s, {1500, 1500, 1550});
    bench.said(at(3s));
    EXPECT_FALSE(selector.outvoted(2));
}

TEST(SelectionMedian, CallsNobodyALiarOfThreeThatAllDiffer) {
    // For example, each receiver sends its own signal strength on a channel.
    Bench bench(list(ibus_input(), ibus_input(), ibus_input()),
                list(output_with(SelectionMode::median, 3)));
    Inputs inputs(bench);
    inputs.run(5s, {1200, 1500, 1900});
    EXPECT_EQ(first_channel(bench, 5s), 1500);
    EXPECT_EQ(bench.engine().outputs()[0].selector().outvoted_count(), 0U);
}

TEST(SelectionMedian, WhereEachOfThreeAgreesWithAnotherOnAnotherChannelNoneIsALiar) {
    Bench bench(list(ibus_input(), ibus_input(), ibus_input()),
                list(output_with(SelectionMode::median, 3)));
    for (Instant when = at(1ms); when < at(3s); when += 8ms) {
        for (const std::size_t input : {0U, 1U, 2U}) {
            ChannelFrame frame;
            for (std::size_t channel = 0; channel < 14; ++channel) {
                frame.set(channel, us(channel < 3 && channel == input ? 1900 : 1500));
            }
            bench.send(IbusEncoder(), input, when, frame);
        }
    }
    EXPECT_FALSE(bench.said(at(3s)).failsafe);
    EXPECT_EQ(bench.engine().outputs()[0].selector().outvoted_count(), 0U);
}

TEST(SelectionMedian, ALiarThatIsLeftAloneGetsNoControl) {
    Bench bench(list(ibus_input(), ibus_input(), ibus_input()),
                list(output_with(SelectionMode::median, 3)));
    Inputs inputs(bench);
    inputs.run(2s, {1500, 1500, 1900});
    inputs.run(4s, {0, 0, 1900});
    EXPECT_TRUE(bench.said(at(4s)).failsafe);
}

TEST(SelectionMedian, AChannelThatOnlySomeHaveIsTheMedianOfThose) {
    Bench bench(list(ibus_input(), sbus_input(), sbus_input()),
                list(output_with(SelectionMode::median, 3)));
    for (Instant when = at(1ms); when < at(2s); when += 8ms) {
        bench.ibus(0, when, us(1500));  // 14 channels
        for (const std::size_t input : {1U, 2U}) {
            ChannelFrame frame;
            frame.frame_lost = frame.failsafe = false;
            for (std::size_t channel = 0; channel < 16; ++channel) {
                frame.set(channel, us(channel == 15 ? 1700 : 1500));
            }
            bench.send(SbusEncoder(), input, when + 1ms, frame);
        }
    }
    EXPECT_EQ(bench.said(at(2s)).raw[15], raw_of(1700));
}

TEST(Handover, AChannelOfAnInputPicksTheSourceEvenlyOverItsTravel) {
    OutputSettings output = output_with(SelectionMode::priority, 3);
    output.selection.handover = HandoverSettings{.input = 0, .channel = 2};
    Bench bench(list(ibus_input(), ibus_input(), ibus_input()), list(std::move(output)));
    const auto picked_at = [&](Duration from, int handover) {
        for (Instant when = at(from); when < at(from) + 100ms; when += 8ms) {
            bench.ibus(0, when, us(1100), us(handover));
            bench.ibus(1, when + 1ms, us(1200));
            bench.ibus(2, when + 2ms, us(1300));
        }
        return first_channel(bench, from + 100ms);
    };
    EXPECT_EQ(picked_at(1ms, 1000), 1100);
    EXPECT_EQ(picked_at(101ms, 1500), 1200);
    EXPECT_EQ(picked_at(201ms, 2000), 1300);
    EXPECT_EQ(picked_at(301ms, 900), 1100);
}

TEST(Handover, AStickAtABoundaryDoesNotFlutter) {
    OutputSettings output = output_with(SelectionMode::priority, 2);
    output.selection.handover = HandoverSettings{.input = 0, .channel = 2};
    Bench bench(list(ibus_input(), ibus_input()), list(std::move(output)));
    int changes = 0;
    int latest = 0;
    for (int step = 0; step < 50; ++step) {
        const Instant when = at(1ms) + step * 10ms;
        bench.ibus(0, when, us(1100), us(step % 2 == 0 ? 1490 : 1510));
        bench.ibus(1, when + 1ms, us(1200));
        const int now = 880 + bench.said(when + 9ms).raw[0] * 5 / 8;
        changes += latest != 0 && now != latest ? 1 : 0;
        latest = now;
    }
    EXPECT_EQ(changes, 0);
}

TEST(Handover, ToAnInputThatIsLostDoesNotHappen) {
    OutputSettings output = output_with(SelectionMode::priority, 2);
    output.selection.handover = HandoverSettings{.input = 0, .channel = 2};
    Bench bench(list(ibus_input(), ibus_input()), list(std::move(output)));
    for (Instant when = at(1ms); when < at(1s); when += 8ms) {
        bench.ibus(0, when, us(1100), us(2000));
    }
    EXPECT_EQ(first_channel(bench, 1s), 1100);
}

TEST(Handover, LeavesTheFirstPositionToTheVoteWithAMedian) {
    OutputSettings output = output_with(SelectionMode::median, 3);
    output.selection.handover = HandoverSettings{.input = 0, .channel = 2};
    Bench bench(list(ibus_input(), ibus_input(), ibus_input()), list(std::move(output)));
    const auto picked_at = [&](Duration from, int handover) {
        for (Instant when = at(from); when < at(from) + 100ms; when += 8ms) {
            bench.ibus(0, when, us(1480), us(handover));
            bench.ibus(1, when + 1ms, us(1520), us(handover));
            bench.ibus(2, when + 2ms, us(1500), us(handover));
        }
        return first_channel(bench, from + 100ms);
    };
    EXPECT_EQ(picked_at(1ms, 1000), 1500);
    EXPECT_EQ(picked_at(101ms, 1375), 1480);
    EXPECT_EQ(picked_at(201ms, 1625), 1520);
    EXPECT_EQ(picked_at(301ms, 2000), 1500);
}

TEST(Handover, ToALiarEndsInFailsafeWhenNobodyPicksItAnyMore) {
    // The liar still sends, but the loss of the inputs that outvoted it counts.
    OutputSettings output = output_with(SelectionMode::median, 3);
    output.selection.handover = HandoverSettings{.input = 0, .channel = 2};
    Bench bench(list(ibus_input(), ibus_input(), ibus_input()), list(std::move(output)));
    const auto run = [&](Duration from, Duration until, int handover) {
        for (Instant when = at(from); when < at(until); when += 8ms) {
            if (handover != 0) {
                bench.ibus(0, when, us(1500), us(handover));
                bench.ibus(1, when + 1ms, us(1500), us(handover));
            }
            bench.ibus(2, when + 2ms, us(1900), us(1000));
        }
    };
    run(1ms, 2s, 1000);
    run(2001ms, 3s, 2000);
    EXPECT_EQ(first_channel(bench, 3s), 1900);
    run(3001ms, 5s, 0);
    EXPECT_TRUE(bench.said(at(5s)).failsafe);
}

TEST(Changeover, HappensAtOnceWhereNobodyAskedForMore) {
    Bench bench(list(ibus_input(), ibus_input()), list(output_with(SelectionMode::priority, 2)));
    Inputs inputs(bench);
    inputs.run(500ms, {1000, 2000});
    inputs.run(700ms, {0, 2000});
    EXPECT_EQ(first_channel(bench, 700ms), 2000);
    for (std::size_t i = 1; i < bench.seen().size(); ++i) {
        EXPECT_LE(bench.seen()[i].at - bench.seen()[i - 1].at, 10ms) << "costs no period";
    }
}

TEST(Changeover, WithASlewTakesNoLargerStepThanThatAndArrives) {
    OutputSettings output = output_with(SelectionMode::priority, 2);
    output.selection.changeover_us_per_second = 2000;
    Bench bench(list(ibus_input(), ibus_input()), list(std::move(output)));
    Inputs inputs(bench);
    inputs.run(500ms, {1000, 2000});
    inputs.run(1200ms, {0, 2000});
    EXPECT_EQ(first_channel(bench, 1200ms), 2000);
    int largest = 0;
    for (std::size_t i = 2; i < bench.seen().size(); ++i) {
        largest = std::max(
            largest, std::abs(bench.seen()[i].frame.raw[0] - bench.seen()[i - 1].frame.raw[0]));
    }
    EXPECT_EQ(largest, 32) << "20 us in 10 ms are 32 raw steps";
}

TEST(Changeover, AStickThatMovesAfterwardsIsNotSlowed) {
    OutputSettings output = output_with(SelectionMode::priority, 2);
    output.selection.changeover_us_per_second = 2000;
    Bench bench(list(ibus_input(), ibus_input()), list(std::move(output)));
    Inputs inputs(bench);
    inputs.run(500ms, {1500, 1500});
    inputs.run(1200ms, {0, 1500});
    inputs.run(1220ms, {0, 2000});
    EXPECT_EQ(first_channel(bench, 1220ms), 2000);
}

TEST(FailsafeSlew, LeadsIntoThePresetsAndBack) {
    OutputSettings output = sbus_output({0}, {.slew_us_per_second = 1000});
    Bench bench(list(ibus_input()), list(std::move(output)));
    Inputs inputs(bench);
    inputs.run(500ms, {2000});
    inputs.run(1400ms, {0});
    EXPECT_TRUE(bench.said(at(1s)).failsafe);
    EXPECT_EQ(first_channel(bench, 1400ms), 1500);
    inputs.run(3s, {2000});
    EXPECT_EQ(first_channel(bench, 3s), 2000);
    EXPECT_FALSE(bench.said(at(3s)).frame_lost);
    for (std::size_t i = 3; i < bench.seen().size(); ++i) {
        const int step = bench.seen()[i].frame.raw[0] - bench.seen()[i - 1].frame.raw[0];
        EXPECT_LE(std::abs(step), 16) << "10 us in 10 ms are 16 raw steps; frame " << i;
    }
}

TEST(ReleaseWhen, KeepsTheOutputInFailsafeUntilTheThrottleIsLow) {
    OutputSettings output =
        sbus_output({0}, {.release_when = ValueRule{.channel = 2, .below = us(1050)}});
    Bench bench(list(ibus_input()), list(std::move(output)));
    const auto throttle = [&](Duration from, Duration until, int third) {
        for (Instant when = at(from); when < at(until); when += 8ms) {
            bench.ibus(0, when, us(1100), us(third));
        }
    };
    throttle(1ms, 500ms, 1500);
    EXPECT_TRUE(bench.said(at(500ms)).failsafe) << "at the start too";
    EXPECT_TRUE(bench.engine().outputs()[0].state(at(500ms)).awaits_release);
    throttle(501ms, 600ms, 1049);
    EXPECT_FALSE(bench.said(at(600ms)).failsafe);
    throttle(601ms, 1s, 1500);
    EXPECT_FALSE(bench.said(at(1s)).failsafe) << "only the way back waits";
    throttle(2s, 4s, 1500);  // after a second of silence
    EXPECT_TRUE(bench.said(at(4s)).failsafe);
    throttle(4001ms, 4100ms, 1000);
    EXPECT_FALSE(bench.said(at(4100ms)).failsafe);
}

TEST(PowerOnGuard, GivesControlForTheFirstTimeAfterAnUnbrokenRun) {
    Bench bench(list(ibus_input()), list(sbus_output({0}, {.power_on = 2s})));
    bench.ibus_run(0, at(1ms), at(1500ms), us(1100));
    bench.ibus_run(0, at(1700ms), at(5s), us(1100));  // a pause breaks the run
    EXPECT_TRUE(bench.said(at(2100ms)).failsafe);
    EXPECT_TRUE(bench.said(at(3690ms)).failsafe);
    EXPECT_FALSE(bench.said(at(3720ms)).failsafe);
}

TEST(ForcedFailsafe, EndsControlAtOnceAndGivesItBackAfterRecovery) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    bench.ibus_run(0, at(1ms), at(1s), us(1100));
    bench.said(at(995ms));
    bench.engine().output(0).force_failsafe(true, at(996ms));
    EXPECT_TRUE(bench.said(at(1s)).failsafe);
    bench.ibus_run(0, at(1001ms), at(3s), us(1100));
    EXPECT_TRUE(bench.said(at(2990ms)).failsafe);
    bench.engine().output(0).force_failsafe(false, at(2991ms));
    bench.ibus_run(0, at(3001ms), at(5s), us(1100));
    const auto first_free = std::ranges::find_if(bench.seen(), [](const Seen& seen) {
        return seen.at > at(2991ms) && !seen.frame.failsafe;
    });
    ASSERT_NE(first_free, bench.seen().end());
    EXPECT_EQ(first_free->at, at(3500ms)) << "500 ms of recovery, then the next on the grid";
}

}  // namespace
}  // namespace tribus::test::serial::engine_selection_test
