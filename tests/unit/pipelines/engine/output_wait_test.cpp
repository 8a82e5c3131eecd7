#include "pipelines/engine/output_wait.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/state_text/cause_text.h"
#include "app/state_text/wait_text.h"
#include "tests/unit/pipelines/engine/engine_bench.h"

/// What an output that is not in control says it waits for.
namespace tribus::test::serial::output_wait_test {
namespace {

const std::vector<std::string> kNames{"radio", "backup"};

FailsafeSettings proof_of(Duration proof) {
    return {.hold = 0ms, .recover = proof, .power_on = proof};
}

std::string awaited(Bench& bench, Duration when) {
    bench.said(at(when));
    const OutputState state = bench.engine().outputs()[0].state(at(when));
    return wait_text(state, bench.engine().wait(0, at(when)), kNames);
}

LinkCause told_cause(Bench& bench, std::size_t input, Duration when) {
    bench.said(at(when));
    return bench.engine().input_state(input, at(when)).cause;
}

/// Sends an SBUS frame each 10 ms; of each `of` of them the last is marked frame-lost.
void sbus_run(Bench& bench, Duration from, Duration until, int of) {
    int number = 0;
    for (Duration when = from; when < until; when += 10ms) {
        bench.sbus(0, at(when), us(1500), ++number % of == 0, false);
    }
}

TEST(OutputWait, IsForALinkThatWasNeverHeard) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    EXPECT_EQ(awaited(bench, 200ms), "radio: never seen");
}

TEST(OutputWait, IsForALinkThatIsLostWithItsCause) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    bench.ibus_run(0, at(1ms), at(400ms), us(1500));
    EXPECT_EQ(awaited(bench, 400ms), "") << "in control";
    EXPECT_EQ(awaited(bench, 1s), "radio: wire silent (no bytes any more)");
}

TEST(OutputWait, IsForTheRestOfTheTimeOfGoodFrames) {
    Bench bench(list(ibus_input()), list(sbus_output({0}, proof_of(500ms))));
    bench.ibus_run(0, at(1ms), at(301ms), us(1500));
    EXPECT_EQ(awaited(bench, 301ms), "radio: good for 0.3 of 0.5 s");
}

TEST(OutputWait, IsForTheInputThatNeedsTheLeastTime) {
    Bench bench(list(ibus_input(), ibus_input()), list(sbus_output({0, 1}, proof_of(500ms))));
    for (Duration when = 1ms; when < 301ms; when += 8ms) {
        bench.ibus(1, at(when), us(1500));
        if (when > 100ms) {
            bench.ibus(0, at(when), us(1500));
        }
    }
    bench.said(at(301ms));
    EXPECT_EQ(bench.engine().wait(0, at(301ms)).input, 1U);
}

TEST(OutputWait, NamesTheShareOfFramesThatAreMarkedFrameLost) {
    Bench bench(list(sbus_input()), list(sbus_output({0}, proof_of(500ms))));
    sbus_run(bench, 10ms, 310ms, 5);
    EXPECT_EQ(awaited(bench, 312ms),
              "radio: good for 0.3 of 0.5 s; 6 of its latest 30 frames marked frame-lost");
}

/// A rule hits each 120 ms, so the link never proves itself.
TEST(OutputWait, NamesTheLossThatBeganTheProofAnew) {
    Bench bench(list(sbus_input({{.channel = 0, .above = us(1900)}})),
                list(sbus_output({0}, proof_of(500ms))));
    for (int number = 1; number <= 50; ++number) {
        bench.sbus(0, at(number * 10ms), us(number % 12 == 0 ? 1950 : 1500), false, false);
    }
    EXPECT_EQ(awaited(bench, 505ms),
              "radio: good for 0.0 of 0.5 s; lost 0.0 s ago: radio lost (a failsafe_when rule says "
              "so)");
}

TEST(OutputWait, IsForAFirstFrameUntilBytesWithoutOneHaveComeForTheTimeout) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    const std::array<std::uint8_t, 1> noise{0x55};
    for (Duration when = 1ms; when < 200ms; when += 20ms) {
        bench.loop().receive(input_station(0), noise, at(when));
    }
    EXPECT_EQ(awaited(bench, 90ms), "radio: never seen");
    EXPECT_EQ(awaited(bench, 190ms), "radio: garbled (bytes, but no frames)");
}

TEST(OutputText, SaysNothingOfAModuleWhoseDeviceIsGone) {
    OutputState state;
    state.stage = OutputStage::cannot_send;
    state.obstacle = SendObstacle::device;
    state.hearing = Hearing::unreadable;
    EXPECT_EQ(output_text(state, kNames), "cannot send: its device is gone");
}

TEST(OutputWait, NamesTheValueThatIsNotPlausible) {
    InputSettings input = ibus_input();
    input.supervision.plausible = PulseRange{us(900), us(2100)};
    Bench bench(list(std::move(input)), list(sbus_output({0}, proof_of(500ms))));
    bench.ibus_run(0, at(1ms), at(300ms), us(1500));
    bench.ibus(0, at(305ms), us(1500), us(2158));
    EXPECT_EQ(awaited(bench, 310ms),
              "radio: good for 0.3 of 0.5 s; implausible frames: channel 3 is at 2158 us, "
              "plausible are 900 to 2100 us");
}

TEST(OutputWait, IsForThreeGoodFrames) {
    Bench bench(list(ibus_input()), list(sbus_output({0}, proof_of(50ms))));
    bench.ibus(0, at(1ms), us(1500));
    bench.ibus(0, at(91ms), us(1500));
    EXPECT_EQ(awaited(bench, 100ms), "radio: 2 of 3 good frames");
}

TEST(OutputWait, IsForAGoodFrameWhereMarkedOnesKeepTheLink) {
    InputSettings input = sbus_input();
    input.supervision.frame_lost_run = 2s;
    Bench bench(list(std::move(input)), list(sbus_output({0}, proof_of(500ms))));
    sbus_run(bench, 10ms, 100ms, 100);
    for (Duration when = 100ms; when <= 300ms; when += 10ms) {
        bench.sbus(0, at(when), us(1500), true, false);
    }
    EXPECT_EQ(
        awaited(bench, 300ms),
        "radio: a good frame, the latest is 210 ms old of at most 100 ms; 21 of its latest 30 "
        "frames marked frame-lost");
}

TEST(OutputWait, IsForYoungerFramesWhereTheTimeoutDoesNotLastForAPeriod) {
    InputSettings input = ibus_input();
    input.supervision.timeout = 20ms;
    OutputSettings output = sbus_output({0});
    output.schedule.period = 15ms;
    Bench bench(list(std::move(input)), list(std::move(output)));
    bench.ibus_run(0, at(1ms), at(2ms), us(1500));
    EXPECT_EQ(awaited(bench, 10ms), "radio: a good frame, the latest is 9 ms old of at most 5 ms");
}

TEST(OutputWait, IsForTheConditionOfReleaseWhen) {
    FailsafeSettings failsafe{.release_when = ValueRule{.channel = 2, .below = us(1050)}};
    Bench bench(list(ibus_input()), list(sbus_output({0}, failsafe)));
    bench.ibus_run(0, at(1ms), at(400ms), us(1100));
    EXPECT_EQ(awaited(bench, 400ms), "release_when: channel 3 below 1050 us; it is at 1200 us");
    EXPECT_EQ(told_cause(bench, 0, 400ms), LinkCause::good) << "its input can be used";
}

TEST(OutputWait, IsForTheLineThatForcesFailsafeAndThenForRecover) {
    Bench bench(list(ibus_input()), list(sbus_output({0}, proof_of(500ms))),
                {{.role = LineRole::force_failsafe, .outputs = {0}, .debounce = 0ms}});
    LineLevels active = kNoLineActive;
    active.set(0, true);
    bench.engine().set_lines(active, at(0ms));
    bench.ibus_run(0, at(1ms), at(600ms), us(1500));
    EXPECT_EQ(awaited(bench, 600ms), "the GPIO line that forces failsafe");
    bench.engine().set_lines(kNoLineActive, at(600ms));
    bench.ibus_run(0, at(601ms), at(800ms), us(1500));
    EXPECT_EQ(awaited(bench, 800ms), "0.2 of 0.5 s after failsafe was forced");
}

TEST(OutputWait, IsForTheInputThatIsNearestToControl) {
    Bench bench(list(ibus_input(), ibus_input()), list(sbus_output({0, 1}, proof_of(500ms))));
    EXPECT_EQ(awaited(bench, 50ms), "radio: never seen") << "the preferred one";
    bench.ibus_run(1, at(101ms), at(301ms), us(1500));
    EXPECT_EQ(awaited(bench, 301ms), "backup: good for 0.2 of 0.5 s");
}

/// The whole time of good frames still lies before the radio.
TEST(OutputWait, IsNotForAnInputWithoutAGoodFrameWhereAnotherHasSome) {
    InputSettings radio = sbus_input();
    radio.supervision.frame_lost_run = 2s;
    Bench bench(list(std::move(radio), ibus_input()), list(sbus_output({0, 1}, proof_of(500ms))));
    for (Duration when = 0ms; when < 300ms; when += 10ms) {
        bench.sbus(0, at(when), us(1500), when >= 50ms, false);
        bench.ibus(1, at(when + 1ms), us(1500));
    }
    EXPECT_EQ(awaited(bench, 300ms), "backup: good for 0.2 of 0.5 s");
}

TEST(OutputWait, IsNotForAnotherNodeWhereThatDoesNotMatter) {
    OutputSettings output = sbus_output({0}, proof_of(500ms));
    output.yield_to_foreign_sender = false;
    Bench bench(list(ibus_input()), list(std::move(output)),
                {{.role = LineRole::force_failsafe, .outputs = {0}, .debounce = 0ms}});
    LineLevels active = kNoLineActive;
    active.set(0, true);
    bench.engine().set_lines(active, at(0ms));
    bench.ibus_run(0, at(1ms), at(600ms), us(1500));
    bench.engine().set_lines(kNoLineActive, at(600ms));
    for (int frame = 0; frame < 3; ++frame) {
        bench.engine().output(0).foreign_frame_seen(at(610ms));
    }
    EXPECT_EQ(awaited(bench, 620ms), "0.0 of 0.5 s after failsafe was forced");
}

TEST(OutputWait, IsForWhatKeepsItsFramesFromLeaving) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    bench.engine().output(0).set_device_present(false);
    EXPECT_EQ(awaited(bench, 0ms), "its device, which is gone");
}

TEST(InputState, IsUnprovedUntilAnOutputCanUseItsFrames) {
    Bench bench(list(ibus_input(), ibus_input()), list(sbus_output({0}, proof_of(500ms))));
    for (Duration when = 1ms; when < 490ms; when += 8ms) {
        bench.ibus(0, at(when), us(1500));
        bench.ibus(1, at(when), us(1500));
    }
    EXPECT_EQ(told_cause(bench, 0, 490ms), LinkCause::unproved);
    EXPECT_EQ(told_cause(bench, 1, 490ms), LinkCause::good) << "it feeds no output";
    bench.ibus_run(0, at(490ms), at(510ms), us(1500));
    EXPECT_EQ(told_cause(bench, 0, 510ms), LinkCause::good);
}

/// The output of 15 ms takes the frame of 80 ms at 150 ms; only at 165 ms it would be too old.
TEST(InputState, IsGoodWhileAnOutputIsUnderItsControl) {
    OutputSettings output = sbus_output({0});
    output.schedule.period = 15ms;
    Bench bench(list(ibus_input()), list(std::move(output)));
    bench.ibus_run(0, at(1ms), at(81ms), us(1500));
    for (Duration when = 150ms; when < 165ms; when += 1ms) {
        const LinkCause told = told_cause(bench, 0, when);
        ASSERT_EQ(bench.engine().outputs()[0].stage(), OutputStage::control);
        EXPECT_EQ(told, LinkCause::good) << when / 1ms;
    }
}

/// A DBC output can send it as a signal.
TEST(CauseOfAFrame, IsNotGoodBeforeTheInputIsInControl) {
    Bench bench(list(ibus_input()), list(sbus_output({0}, proof_of(500ms))));
    const auto cause = [&bench](Duration when) {
        bench.said(at(when));
        return bench.engine().outputs()[0].latest().cause;
    };
    bench.ibus_run(0, at(1ms), at(400ms), us(1500));
    EXPECT_EQ(cause(400ms), LinkCause::unproved);
    bench.ibus_run(0, at(401ms), at(600ms), us(1500));
    EXPECT_EQ(cause(600ms), LinkCause::good);
}

TEST(WaitWatch, TellsAChangeAfterItsPatience) {
    WaitWatch watch;
    EXPECT_EQ(watch.look("silent", false, at(0ms)), "");
    EXPECT_EQ(watch.look("silent", false, at(699ms)), "");
    EXPECT_EQ(watch.look("silent", false, at(700ms)), "silent");
}

TEST(WaitWatch, TellsAChangeAtOnceWithAChangeOfTheState) {
    WaitWatch watch;
    EXPECT_EQ(watch.look("silent", true, at(0ms)), "silent");
    EXPECT_EQ(watch.look("", true, at(10ms)), "");
}

TEST(WaitWatch, SaysNothingOfARecoveryWithoutTrouble) {
    WaitWatch watch;
    watch.look("silent", true, at(0ms));
    EXPECT_EQ(watch.look("good", false, at(1000ms)), "silent");
    EXPECT_EQ(watch.look("good", false, at(1500ms)), "silent");
    EXPECT_EQ(watch.look("", true, at(1501ms)), "");
}

TEST(WaitWatch, HasPatienceForAllThingsTogetherThatItDidNotTell) {
    WaitWatch watch;
    watch.look("silent", true, at(0ms));
    watch.look("good", false, at(100ms));
    watch.look("lost", false, at(500ms));
    EXPECT_EQ(watch.look("good", false, at(800ms)), "good");
}

TEST(DurationText, IsShortAndExact) {
    using namespace std::chrono_literals;
    const std::vector<std::pair<Duration, std::string>> cases{
        {0ms, "0 ms"},          {180ms, "180 ms"},    {999ms, "999 ms"},    {1s, "1.0 s"},
        {4249ms, "4.2 s"},      {59900ms, "59.9 s"},  {60s, "1 min 0 s"},   {192s, "3 min 12 s"},
        {3599s, "59 min 59 s"}, {3600s, "1 h 0 min"}, {7500s, "2 h 5 min"}, {90000s, "25 h 0 min"}};
    for (const auto& [duration, text] : cases) {
        EXPECT_EQ(duration_text(duration), text);
    }
}

}  // namespace
}  // namespace tribus::test::serial::output_wait_test
