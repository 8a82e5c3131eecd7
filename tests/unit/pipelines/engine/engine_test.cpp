#include "pipelines/engine/engine.h"

#include <array>
#include <bitset>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/pipelines/engine/engine_bench.h"

namespace tribus::test::serial::engine_test {
namespace {

TEST(EngineFailsafe, BeforeTheFirstGoodFrameAnOutputIsInFailsafe) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    const SbusFrame frame = bench.said(at(50ms));
    EXPECT_TRUE(frame.failsafe);
    EXPECT_TRUE(frame.frame_lost);
    EXPECT_EQ(frame.raw[2], 173);
    EXPECT_EQ(frame.raw[0], 992);
}

TEST(EngineFailsafe, AFrameThatARuleTakesForFailsafeCountsAsOne) {
    Bench bench(list(ibus_input({{.channel = 2, .below = us(950)}})), list(sbus_output({0})));
    bench.ibus(0, at(5ms), us(1500), us(1000));
    EXPECT_EQ(bench.engine().inputs()[0].counts().failsafe_frames, 0U);
    bench.ibus(0, at(15ms), us(1500), us(940));
    EXPECT_EQ(bench.engine().inputs()[0].counts().failsafe_frames, 1U);
}

TEST(EngineFailsafe, AnOutputWithoutInputsSaysThatAllIsGood) {
    Bench bench({}, list(sbus_output({})));
    const SbusFrame frame = bench.said(at(50ms));
    EXPECT_FALSE(frame.failsafe);
    EXPECT_FALSE(frame.frame_lost);
    EXPECT_EQ(bench.engine().outputs()[0].latest().cause, LinkCause::good);
}

TEST(EngineFailsafe, TheFirstGoodFrameGivesControlAtOnce) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    bench.ibus(0, at(15ms), us(1100));
    const SbusFrame frame = bench.said(at(20ms));
    EXPECT_FALSE(frame.failsafe);
    EXPECT_FALSE(frame.frame_lost);
    EXPECT_EQ(frame.raw[0], raw_of(1100));
}

TEST(EngineFailsafe, ValuesAreMarkedBeforeTheyOutliveTheTimeoutAndHeldThenPreset) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    bench.ibus(0, at(5ms), us(1100));
    // Lost at 105 ms: the frame of 90 ms counts until 100 ms, the one of 100 ms would count until
    // 110 ms.
    EXPECT_FALSE(bench.said(at(90ms)).frame_lost);
    const SbusFrame held = bench.said(at(100ms));
    EXPECT_TRUE(held.frame_lost);
    EXPECT_FALSE(held.failsafe);
    EXPECT_EQ(held.raw[0], raw_of(1100));
    // Held for 300 ms after the loss, until 405 ms.
    EXPECT_FALSE(bench.said(at(390ms)).failsafe);
    const SbusFrame preset = bench.said(at(400ms));
    EXPECT_TRUE(preset.failsafe);
    EXPECT_EQ(preset.raw[0], 992);
}

TEST(EngineFailsafe, ActionHoldGoesOnWithTheLastValuesAndSaysFailsafe) {
    Bench bench(list(ibus_input()), list(sbus_output({0}, {.action = FailsafeAction::hold})));
    bench.ibus(0, at(5ms), us(1100));
    const SbusFrame frame = bench.said(at(2s));
    EXPECT_TRUE(frame.failsafe);
    EXPECT_TRUE(frame.frame_lost);
    EXPECT_EQ(frame.raw[0], raw_of(1100));
}

TEST(EngineFailsafe, ActionHoldIsSilentWhileThereIsNothingToHold) {
    Bench bench(list(ibus_input()), list(sbus_output({0}, {.action = FailsafeAction::hold})));
    bench.said(at(1s));
    EXPECT_TRUE(bench.seen().empty());
}

TEST(EngineFailsafe, ActionSilenceWritesNothingInFailsafe) {
    Bench bench(list(ibus_input()), list(sbus_output({0}, {.action = FailsafeAction::silence})));
    bench.said(at(50ms));
    EXPECT_TRUE(bench.seen().empty());
    bench.ibus(0, at(55ms), us(1100));
    bench.said(at(2s));
    ASSERT_FALSE(bench.seen().empty());
    EXPECT_FALSE(bench.seen().back().frame.failsafe);
    EXPECT_LT(bench.seen().back().at, at(455ms));
}

TEST(EngineFailsafe, ALossThatHoldBridgesNeedsNoRecovery) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    bench.ibus(0, at(5ms), us(1100));
    bench.ibus(0, at(255ms), us(1200));
    const SbusFrame frame = bench.said(at(260ms));
    EXPECT_FALSE(frame.frame_lost);
    EXPECT_EQ(frame.raw[0], raw_of(1200));
}

TEST(EngineFailsafe, TellsSinceWhenItIsInItsStage) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    const auto since = [&bench](Duration when) {
        bench.said(at(when));
        return bench.engine().output(0).look_at_stage(at(when));
    };
    EXPECT_EQ(since(10ms), at(0ms));
    bench.ibus_run(0, at(15ms), at(100ms), us(1100));
    EXPECT_EQ(since(100ms), at(20ms));
    bench.ibus_run(0, at(103ms), at(200ms), us(1100));
    EXPECT_EQ(since(200ms), at(20ms));
    EXPECT_EQ(since(350ms), at(299ms)) << "when its input was lost";
    EXPECT_EQ(since(400ms), at(299ms));
    EXPECT_EQ(since(800ms), at(590ms));
    bench.engine().output(0).set_device_present(false);
    EXPECT_EQ(bench.engine().output(0).look_at_stage(at(820ms)), at(820ms));
}

TEST(EngineFailsafe, CountsEachLossThatHoldBridgesOnceAndNoneThatItDoesNotBridge) {
    const auto hold_entries = [](Duration hold) {
        Bench bench(list(ibus_input()), list(sbus_output({0}, {.hold = hold})));
        bench.ibus_run(0, at(1ms), at(500ms), us(2000));
        bench.ibus_run(0, at(700ms), at(1s), us(2000));
        bench.ibus_run(0, at(1200ms), at(1500ms), us(2000));
        bench.said(at(1500ms));
        return bench.engine().outputs()[0].counts().hold_entries;
    };
    EXPECT_EQ(hold_entries(500ms), 2U);
    EXPECT_EQ(hold_entries(0ms), 0U);
}

TEST(EngineFailsafe, AfterFailsafeControlReturnsOnlyAfterAnUnbrokenRun) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    bench.ibus(0, at(5ms), us(1100));
    bench.ibus_run(0, at(1s), at(1499ms), us(1200));
    EXPECT_TRUE(bench.said(at(1490ms)).failsafe);
    bench.ibus_run(0, at(1500ms), at(1600ms), us(1200));
    EXPECT_FALSE(bench.said(at(1600ms)).failsafe);
    EXPECT_EQ(bench.engine().outputs()[0].counts().recoveries, 1U);
}

TEST(EngineFailsafe, AGapLongerThanTheTimeoutStartsTheRunAnew) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    bench.ibus(0, at(5ms), us(1100));
    bench.ibus_run(0, at(1s), at(1400ms), us(1200));
    bench.ibus_run(0, at(1550ms), at(2040ms), us(1200));
    EXPECT_TRUE(bench.said(at(2040ms)).failsafe);
    bench.ibus_run(0, at(2048ms), at(2100ms), us(1200));
    EXPECT_FALSE(bench.said(at(2100ms)).failsafe);
}

TEST(EngineFailsafe, HoldAndRecoverOfZeroActAtOnce) {
    Bench bench(list(ibus_input()), list(sbus_output({0}, {.hold = 0ms, .recover = 0ms})));
    bench.ibus(0, at(5ms), us(1100));
    EXPECT_TRUE(bench.said(at(100ms)).failsafe);
    bench.ibus(0, at(1s), us(1200));
    EXPECT_FALSE(bench.said(at(1s)).failsafe);
}

TEST(EngineFlags, AFrameLostMarkOfTheInputPassesWhileTheLinkIsUp) {
    Bench bench(list(sbus_input()), list(sbus_output({0})));
    bench.sbus(0, at(1ms), us(1100), false, false);
    bench.sbus(0, at(15ms), us(1100), true, false);
    bench.sbus(0, at(29ms), us(1100), true, false);
    const SbusFrame frame = bench.said(at(30ms));
    EXPECT_TRUE(frame.frame_lost);
    EXPECT_FALSE(frame.failsafe);
}

TEST(EngineFlags, ASplitterThatSaysFrameLostForEverEndsInFailsafe) {
    // ArduPilot issue 31088: Futaba via splitters stays at frame lost and never marks failsafe.
    Bench bench(list(sbus_input()), list(sbus_output({0})));
    bench.sbus(0, at(1ms), us(1100), false, false);
    for (Instant when = at(15ms); when < at(600ms); when += 14ms) {
        bench.sbus(0, when, us(1100), true, false);
    }
    EXPECT_TRUE(bench.said(at(600ms)).failsafe);
}

TEST(EngineFlags, AFailsafeFlagIsALossAtOnce) {
    Bench bench(list(sbus_input()), list(sbus_output({0})));
    for (Instant when = at(1ms); when < at(200ms); when += 14ms) {
        bench.sbus(0, when, us(1100), false, false);
    }
    bench.sbus(0, at(201ms), us(2000), true, true);
    const SbusFrame held = bench.said(at(210ms));
    EXPECT_TRUE(held.frame_lost);
    EXPECT_EQ(held.raw[0], raw_of(1100));
    EXPECT_TRUE(bench.said(at(500ms)).failsafe);
}

TEST(EngineRules, AHeldPresetIsCaughtByItsValue) {
    // FlySky practice: throttle at 900 in the receiver's failsafe (betaflight issue 8877).
    Bench bench(list(ibus_input({{.channel = 2, .below = us(950)}})), list(sbus_output({0})));
    bench.ibus(0, at(5ms), us(1100), us(950));
    EXPECT_FALSE(bench.said(at(10ms)).frame_lost);
    for (Instant when = at(15ms); when < at(400ms); when += 8ms) {
        bench.ibus(0, when, us(1100), us(949));
    }
    EXPECT_TRUE(bench.said(at(400ms)).failsafe);
}

TEST(EngineInputs, TheFirstHealthyInputInOrderIsInControl) {
    Bench bench(list(ibus_input(), ibus_input()), list(sbus_output({0, 1})));
    bench.ibus(1, at(4ms), us(1900));
    EXPECT_EQ(bench.said(at(10ms)).raw[0], raw_of(1900));
    bench.ibus(0, at(15ms), us(1100));
    EXPECT_EQ(bench.said(at(20ms)).raw[0], raw_of(1100));
}

TEST(EngineInputs, ABackupTakesOverWithoutAMarkWhenTheMainInputIsLost) {
    Bench bench(list(ibus_input(), ibus_input()), list(sbus_output({0, 1})));
    bench.ibus(0, at(5ms), us(1100));
    bench.ibus_run(1, at(6ms), at(300ms), us(1900));
    const SbusFrame frame = bench.said(at(120ms));
    EXPECT_EQ(frame.raw[0], raw_of(1900));
    for (const Seen& seen : bench.seen()) {
        EXPECT_TRUE(seen.at < at(5ms) || !seen.frame.frame_lost);
    }
}

TEST(EngineInputs, TheMainInputTakesControlBackAfterRecovering) {
    Bench bench(list(ibus_input(), ibus_input()), list(sbus_output({0, 1})));
    bench.ibus(0, at(5ms), us(1100));
    for (Instant when = at(6ms); when < at(2s); when += 8ms) {
        bench.ibus(1, when, us(1900));
        if (when > at(1s)) {
            bench.ibus(0, when + 1ms, us(1200));
        }
    }
    EXPECT_EQ(bench.said(at(1480ms)).raw[0], raw_of(1900));
    EXPECT_EQ(bench.said(at(1600ms)).raw[0], raw_of(1200));
}

TEST(EngineInputs, OneInputFeedsSeveralOutputsEachWithItsOwnFailsafe) {
    Bench bench(list(ibus_input()), list(sbus_output({0}), sbus_output({0}, {.hold = 0ms})));
    bench.ibus(0, at(5ms), us(1100));
    EXPECT_EQ(bench.said(at(10ms), 0).raw[0], raw_of(1100));
    EXPECT_EQ(bench.said(at(10ms), 1).raw[0], raw_of(1100));
    EXPECT_FALSE(bench.said(at(120ms), 0).failsafe);
    EXPECT_TRUE(bench.said(at(120ms), 1).failsafe);
}

TEST(EngineInputs, TheNewestOfSeveralFramesInOneReadWins) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    std::vector<std::uint8_t> burst;
    for (const int value : {1100, 1200, 1300}) {
        ChannelFrame frame;
        frame.set(0, us(value));
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        const std::size_t length = IbusEncoder(14).write(frame, wire, Instant{});
        burst.insert(burst.end(), wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length));
    }
    bench.loop().receive(input_station(0), burst, at(5ms));
    EXPECT_EQ(bench.said(at(10ms)).raw[0], raw_of(1300));
}

TEST(EngineEnd, EveryOutputSaysFailsafeThreeTimesAndNoInputBringsControlBack) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    bench.ibus_run(0, at(1ms), at(100ms), us(1100));
    bench.said(at(100ms));
    const std::size_t before = bench.seen().size();
    bench.loop().end(at(105ms));
    ASSERT_EQ(bench.seen().size(), before + 3);
    for (std::size_t i = before; i < bench.seen().size(); ++i) {
        EXPECT_TRUE(bench.seen()[i].frame.failsafe);
    }
}

TEST(EngineCounts, DeviceLossesAndFramesAreCounted) {
    Bench bench(list(sbus_input()), list(sbus_output({0})));
    for (Instant when = at(1ms); when < at(100ms); when += 14ms) {
        bench.sbus(0, when, us(1100), false, false);
    }
    bench.engine().device_lost(0);
    const InputCounts& counts = bench.engine().inputs()[0].counts();
    EXPECT_EQ(counts.bytes, 8U * 25U);
    EXPECT_EQ(counts.frames, 8U);
    EXPECT_EQ(counts.device_losses, 1U);
}

}  // namespace
}  // namespace tribus::test::serial::engine_test
