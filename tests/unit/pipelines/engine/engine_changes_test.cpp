#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/dronecan_frames.h"
#include "tests/unit/pipelines/engine/engine_bench.h"

/// The changes of state that an engine writes into its ring, each at its moment.
namespace tribus::test::serial::engine_changes_test {
namespace {

class Changes final : public ChangeSink {
  public:
    explicit Changes(Engine& engine) { engine.tell_changes_to(*this); }
    void add(Change change) override { all.push_back(change); }

    std::vector<Change> all;
};

/// "90 ms input 0: good to wire silent", without the first `known` changes.
std::vector<std::string> told(const Changes& changes, std::size_t known = 0) {
    std::vector<std::string> lines;
    for (const Change& change : std::span(changes.all).subspan(known)) {
        const auto ms =
            std::chrono::duration_cast<std::chrono::milliseconds>(change.at.time_since_epoch());
        const bool input = change.part == Change::Part::input;
        constexpr std::array<std::string_view, 4> kStages{"failsafe", "holding", "control",
                                                          "cannot send"};
        const auto stage = [&](const PartState& state) {
            return input ? std::string(name_of(state.link.cause))
                         : std::string(kStages[static_cast<std::size_t>(state.output.stage)]);
        };
        lines.push_back(std::to_string(ms.count()) + " ms " + (input ? "input " : "output ") +
                        std::to_string(change.index) + ": " + stage(change.was) + " to " +
                        stage(change.now));
    }
    return lines;
}

using Lines = std::vector<std::string>;

TEST(EngineChanges, AreWrittenAtTheFrameThatShowsThem) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    const Changes changes(bench.engine());
    bench.ibus_run(0, at(15ms), at(200ms), us(1100));
    bench.said(at(290ms));
    // Lost at 299 ms: the frame of 290 ms would have to last until 300 ms.
    EXPECT_EQ(told(changes),
              (Lines{"15 ms input 0: never seen to good", "20 ms output 0: failsafe to control",
                     "290 ms output 0: control to holding"}));
    bench.said(at(600ms));
    EXPECT_EQ(told(changes, 3), (Lines{"300 ms input 0: good to wire silent",
                                       "590 ms output 0: holding to failsafe"}));
}

TEST(EngineChanges, SayThatAnInputIsUnprovedUntilAnOutputTakesIt) {
    Bench bench(list(ibus_input()), list(sbus_output({0}, {.power_on = 100ms})));
    const Changes changes(bench.engine());
    bench.ibus_run(0, at(15ms), at(200ms), us(1100));
    EXPECT_EQ(told(changes),
              (Lines{"15 ms input 0: never seen to unproved",
                     "120 ms output 0: failsafe to control", "120 ms input 0: unproved to good"}));
}

TEST(EngineChanges, AreNoneWhileNothingChanges) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    const Changes changes(bench.engine());
    bench.ibus_run(0, at(15ms), at(100ms), us(1100));
    const std::size_t before = changes.all.size();
    bench.ibus_run(0, at(103ms), at(5s), us(1300));
    EXPECT_EQ(changes.all.size(), before);
}

TEST(EngineChanges, TellWhichInputHasTakenOver) {
    Bench bench(list(ibus_input(), ibus_input()), list(sbus_output({0, 1})));
    const Changes changes(bench.engine());
    for (Instant when = at(5ms); when < at(700ms); when += 8ms) {
        if (when < at(300ms)) {
            bench.ibus(0, when, us(1100));
        }
        bench.ibus(1, when, us(1900));
    }
    std::vector<std::size_t> inputs;
    for (const Change& change : changes.all) {
        if (change.part == Change::Part::output) {
            inputs.push_back(change.now.output.input);
        }
    }
    EXPECT_EQ(inputs, (std::vector<std::size_t>{0, 1}));
}

/// What no frame of an output shows is told when somebody looks.
TEST(EngineChanges, TellWhatALookFinds) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    const Changes changes(bench.engine());
    bench.ibus_run(0, at(15ms), at(100ms), us(1100));
    const std::size_t before = changes.all.size();
    bench.engine().output(0).set_device_present(false);
    bench.engine().tell_output(0, at(101ms));
    bench.engine().tell_output(0, at(102ms));
    EXPECT_EQ(told(changes, before), (Lines{"101 ms output 0: control to cannot send"}));
}

TEST(EngineChanges, AreNoneForAReloadWithoutAChangeOfState) {
    Bench before(list(ibus_input()), list(sbus_output({0})));
    before.ibus_run(0, at(15ms), at(100ms), us(1100));
    Bench after(list(ibus_input()), list(sbus_output({0})));
    const Changes changes(after.engine());
    after.engine().continue_from(before.engine(),
                                 {.inputs = {{.from = 0}}, .outputs = {{.from = 0}}, .nodes = {}},
                                 at(100ms));
    after.engine().tell_input(0, at(100ms));
    after.engine().tell_output(0, at(100ms));
    EXPECT_EQ(told(changes), Lines{});
}

TEST(EngineChanges, AreNoneForAnOutputThatBeginsInFailsafe) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    const Changes changes(bench.engine());
    bench.engine().tell_output(0, at(0ms));
    bench.said(at(100ms));
    bench.engine().tell_output(0, at(100ms));
    EXPECT_EQ(told(changes), Lines{});
}

TEST(EngineChanges, AreNoneOfAnOutputThatEnds) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    const Changes changes(bench.engine());
    bench.ibus_run(0, at(15ms), at(100ms), us(1100));
    const std::size_t before = changes.all.size();
    bench.engine().end(at(100ms));
    bench.ibus_run(0, at(103ms), at(200ms), us(1100));
    EXPECT_EQ(told(changes, before), Lines{});
}

/// The bound of docs/status.md, "Changes": 10,000 losses of 20 to 60 ms, at most 20 a second.
TEST(EngineChanges, TellEachOfTenThousandShortLossesWithItsTime) {
    constexpr int kLosses = 10'000;
    InputSettings input = ibus_input();
    input.supervision.timeout = 15ms;
    OutputSettings output = sbus_output({0});
    output.schedule.period = 5ms;
    Bench bench(list(std::move(input)), list(std::move(output)));
    const Changes changes(bench.engine());
    std::minstd_rand random(11);
    Instant now = at(0ms);
    bench.ibus_run(0, now, at(1s), us(1500));
    now = at(1s);
    std::size_t read = changes.all.size();
    int told_losses = 0;
    for (int loss = 0; loss < kLosses; ++loss) {
        // From the timeout on, which the latest frame began 8 ms ago, until the next frame.
        const Duration lasts = 20ms + std::chrono::microseconds(random() % 40'000);
        const Instant lost = now + 7ms;
        const Instant back = lost + lasts;
        bench.ibus_run(0, back, back + 40ms, us(1500));
        now = back + 40ms;
        Instant told_lost{};
        for (; read < changes.all.size(); ++read) {
            const Change& change = changes.all[read];
            if (change.part == Change::Part::output) {
                continue;
            }
            if (change.now.link.cause == LinkCause::wire_silent) {
                told_lost = change.at;
            } else if (told_lost != Instant{}) {
                ++told_losses;
                EXPECT_LE(lost, told_lost);
                EXPECT_LE(told_lost - lost, 5ms) << "the output looks each 5 ms";
                EXPECT_EQ(change.at, back);
                told_lost = {};
            }
        }
    }
    EXPECT_EQ(told_losses, kLosses);
}

TEST(EngineChanges, HaveAConflictOfADroneCanNodeAndItsEnd) {
    dronecan::NodeSettings settings;
    settings.id = 42;
    Engine engine({}, {}, {}, {settings});
    const Changes changes(engine);
    engine.start(at(0ms));
    engine.poll(at(0ms));
    EXPECT_TRUE(changes.all.empty());
    for (const CanFrame& frame : frames_of_message(dronecan::NodeStatus{}, 42, 0)) {
        engine.node(0).receive(frame, at(70ms));
    }
    engine.poll(at(70ms));
    engine.poll(at(71ms));
    engine.poll(at(5070ms));
    ASSERT_EQ(changes.all.size(), 2U);
    const dronecan::NodeState online{.stage = dronecan::NodeStage::online, .id = 42};
    const dronecan::NodeState silent{.stage = dronecan::NodeStage::conflict};
    EXPECT_EQ(changes.all[0].part, Change::Part::node);
    EXPECT_EQ(changes.all[0].at, at(70ms));
    EXPECT_EQ(changes.all[0].was.node, online);
    EXPECT_EQ(changes.all[0].now.node, silent);
    EXPECT_EQ(changes.all[1].at, at(5070ms));
    EXPECT_EQ(changes.all[1].now.node, online);
}

}  // namespace
}  // namespace tribus::test::serial::engine_changes_test
