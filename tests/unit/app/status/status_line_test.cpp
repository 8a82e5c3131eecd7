#include "app/status/status_line.h"

#include <chrono>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::test::status_line_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kStart{100s};

InputStatus told(LinkCause cause) {
    InputStatus status;
    status.state.cause = cause;
    return status;
}
OutputStatus told(const OutputState& state, const OutputWait& wait = {}) {
    OutputStatus status;
    status.state = state;
    status.wait = wait;
    status.stage_since = kStart;
    return status;
}

const InputStatus kGood = told(LinkCause::good);
const InputStatus kSilent = told(LinkCause::wire_silent);
const OutputStatus kControl = told({.stage = OutputStage::control, .input = 0});
const OutputStatus kHolding = told({.stage = OutputStage::holding});
const OutputStatus kFailsafe =
    told({.stage = OutputStage::failsafe}, {.awaited = Awaited::link, .input = 0});

Configuration named(const std::vector<std::string>& inputs,
                    const std::vector<std::string>& outputs) {
    Configuration configuration;
    for (const std::string& name : inputs) {
        configuration.inputs.emplace_back().name = name;
    }
    for (const std::string& name : outputs) {
        configuration.outputs.emplace_back().name = name;
    }
    return configuration;
}

std::string line(const Configuration& configuration, const std::vector<InputStatus>& inputs,
                 const std::vector<OutputStatus>& outputs) {
    return status_line(configuration, inputs, outputs, kStart, kStart);
}

const Configuration kOne = named({"receiver"}, {"servos"});

std::string one(const InputStatus& input, OutputStatus output, Duration since = 0s) {
    output.stage_since = kStart - since;
    return line(kOne, {input}, {output});
}

TEST(StatusLine, TellsWhoControlsAnOutput) {
    EXPECT_EQ(one(kGood, kControl), "servos: under control of receiver; receiver: good");
}

TEST(StatusLine, TellsWhyAnOutputIsInFailsafe) {
    EXPECT_EQ(one(kSilent, kFailsafe),
              "servos: in failsafe; receiver: wire silent (no bytes any more)");
}

TEST(StatusLine, TellsWhyAnOutputCannotSendWhateverItsInputSays) {
    const OutputStatus gone =
        told({.stage = OutputStage::cannot_send, .obstacle = SendObstacle::device});
    EXPECT_EQ(one(kGood, gone), "servos: cannot send: its device is gone; receiver: good");
    const OutputStatus off =
        told({.stage = OutputStage::cannot_send, .obstacle = SendObstacle::bus});
    EXPECT_EQ(one(kGood, off), "servos: cannot send: the bus takes nothing; receiver: good");
}

TEST(StatusLine, TellsWhatAnOutputWaitsForAlthoughItsInputIsGood) {
    const OutputStatus waits =
        told({.stage = OutputStage::failsafe, .awaits_release = true}, {.awaited = Awaited::line});
    EXPECT_EQ(
        one(kGood, waits, 4s),
        "servos: in failsafe for more than 3 s; waits for the GPIO line that forces failsafe; "
        "receiver: good");
}

TEST(StatusLine, TellsInStepsForHowLong) {
    EXPECT_EQ(one(kSilent, kFailsafe, 900ms),
              "servos: in failsafe; receiver: wire silent (no bytes any more)");
    EXPECT_EQ(one(kSilent, kFailsafe, 2999ms),
              "servos: in failsafe for more than 1 s; receiver: wire silent (no bytes any more)");
    EXPECT_EQ(one(kSilent, kFailsafe, 9900ms),
              "servos: in failsafe for more than 3 s; receiver: wire silent (no bytes any more)");
    EXPECT_EQ(one(kSilent, kFailsafe, 3h),
              "servos: in failsafe for more than an hour; "
              "receiver: wire silent (no bytes any more)");
}

TEST(StatusLine, SaysFirstThatTheDataThreadStands) {
    const std::vector inputs{kGood};
    const std::vector outputs{kControl};
    EXPECT_EQ(status_line(kOne, inputs, outputs, kStart, kStart + 1s),
              "servos: under control of receiver; receiver: good");
    EXPECT_EQ(status_line(kOne, inputs, outputs, Instant{}, kStart),
              "servos: under control of receiver; receiver: good")
        << "it has not begun yet";
    EXPECT_EQ(status_line(kOne, inputs, outputs, kStart, kStart + 1001ms),
              "the data thread stands still: what follows is old; "
              "servos: under control of receiver; receiver: good");
}

TEST(StatusLine, HasTheWorstFirst) {
    EXPECT_EQ(line(named({"main", "backup"}, {"lamp", "bus", "servos"}), {kGood, kSilent},
                   {kControl, kHolding, kFailsafe}),
              "servos: in failsafe; backup: wire silent (no bytes any more); "
              "bus: holding the last values, marked frame-lost; "
              "lamp: under control of main; main: good");
}

TEST(StatusLine, SaysThatHeldValuesAreUnmarkedOnAWireThatCannotMarkThem) {
    OutputStatus holding = kHolding;
    holding.state.marks_frame_lost = false;
    EXPECT_EQ(line(named({}, {"servos"}), {}, {holding}),
              "servos: holding the last values, unmarked: its protocol has no frame-lost mark");
}

TEST(StatusLine, LeavesOutWhatDoesNotFitAndSaysHowMuch) {
    const std::string text =
        line(named({}, std::vector<std::string>(64, "output")), {}, std::vector(64, kFailsafe));
    EXPECT_LT(text.size(), 450U);
    EXPECT_TRUE(text.ends_with("; and 45 more")) << text;
}

TEST(StatusLine, StaysOneLineWhateverTheNames) {
    EXPECT_EQ(line(named({}, {"a\nREADY=1"}), {}, {kFailsafe}), "a READY=1: in failsafe");
}

TEST(StatusLine, SaysThatItRunsWithNothingButSensorBuses) {
    EXPECT_EQ(line({}, {}, {}), "running");
}

}  // namespace
}  // namespace tribus::test::status_line_test
