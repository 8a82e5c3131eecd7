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
    return status;
}

const InputStatus kGood = told(LinkCause::good);
const InputStatus kSilent = told(LinkCause::wire_silent);
const OutputStatus kControl = told({.stage = OutputStage::control, .input = 0});
const OutputStatus kHolding = told({.stage = OutputStage::holding});
const OutputStatus kFailsafe =
    told({.stage = OutputStage::failsafe}, {.awaited = Awaited::link, .input = 0});

std::string one(StatusLine& line, const InputStatus& input, const OutputStatus& output,
                Duration after = 0s) {
    return line.text(std::vector{input}, std::vector{output}, kStart + after);
}

class StatusLineTest : public testing::Test {
  protected:
    StatusLine line_{{"receiver"}, {"servos"}};
};

TEST_F(StatusLineTest, TellsWhoControlsAnOutput) {
    EXPECT_EQ(one(line_, kGood, kControl), "servos: under control of receiver; receiver: good");
}

TEST_F(StatusLineTest, TellsWhyAnOutputIsInFailsafe) {
    EXPECT_EQ(one(line_, kSilent, kFailsafe),
              "servos: in failsafe; receiver: wire silent (no bytes any more)");
}

TEST_F(StatusLineTest, TellsWhyAnOutputCannotSendWhateverItsInputSays) {
    const OutputStatus gone =
        told({.stage = OutputStage::cannot_send, .obstacle = SendObstacle::device});
    EXPECT_EQ(one(line_, kGood, gone), "servos: cannot send: its device is gone; receiver: good");
    const OutputStatus off =
        told({.stage = OutputStage::cannot_send, .obstacle = SendObstacle::bus});
    EXPECT_EQ(one(line_, kGood, off), "servos: cannot send: the bus takes nothing; receiver: good");
}

TEST_F(StatusLineTest, TellsWhatAnOutputWaitsForAlthoughItsInputIsGood) {
    const OutputStatus waits =
        told({.stage = OutputStage::failsafe, .awaits_release = true}, {.awaited = Awaited::line});
    one(line_, kGood, waits);
    EXPECT_EQ(
        one(line_, kGood, waits, 4s),
        "servos: in failsafe for more than 3 s; waits for the GPIO line that forces failsafe; "
        "receiver: good");
}

TEST_F(StatusLineTest, TellsInStepsForHowLong) {
    one(line_, kSilent, kFailsafe);
    EXPECT_EQ(one(line_, kSilent, kFailsafe, 900ms),
              "servos: in failsafe; receiver: wire silent (no bytes any more)");
    EXPECT_EQ(one(line_, kSilent, kFailsafe, 9900ms),
              "servos: in failsafe for more than 3 s; receiver: wire silent (no bytes any more)");
    EXPECT_EQ(one(line_, kSilent, kFailsafe, 3h),
              "servos: in failsafe for more than an hour; "
              "receiver: wire silent (no bytes any more)");
}

TEST_F(StatusLineTest, ANewFailsafeBeginsToCountAnew) {
    one(line_, kSilent, kFailsafe);
    one(line_, kGood, kControl, 60s);
    EXPECT_EQ(one(line_, kSilent, kFailsafe, 61s),
              "servos: in failsafe; receiver: wire silent (no bytes any more)");
}

TEST(StatusLine, HasTheWorstFirst) {
    StatusLine line({"main", "backup"}, {"lamp", "bus", "servos"});
    EXPECT_EQ(
        line.text(std::vector{kGood, kSilent}, std::vector{kControl, kHolding, kFailsafe}, kStart),
        "servos: in failsafe; backup: wire silent (no bytes any more); "
        "bus: holding the last values, marked frame-lost; "
        "lamp: under control of main; main: good");
}

TEST(StatusLine, SaysThatHeldValuesAreUnmarkedOnAWireThatCannotMarkThem) {
    StatusLine line({}, {"servos"});
    OutputStatus holding = kHolding;
    holding.state.marks_frame_lost = false;
    EXPECT_EQ(line.text({}, std::vector{holding}, kStart),
              "servos: holding the last values, unmarked: its protocol has no frame-lost mark");
}

TEST(StatusLine, LeavesOutWhatDoesNotFitAndSaysHowMuch) {
    const std::vector<std::string> names(64, "output");
    StatusLine line({}, names);
    const std::string text = line.text({}, std::vector(64, kFailsafe), kStart);
    EXPECT_LT(text.size(), 450U);
    EXPECT_TRUE(text.ends_with("; and 45 more")) << text;
}

TEST(StatusLine, StaysOneLineWhateverTheNames) {
    StatusLine line({}, {"a\nREADY=1"});
    EXPECT_EQ(line.text({}, std::vector{kFailsafe}, kStart), "a READY=1: in failsafe");
}

TEST(StatusLine, SaysThatItRunsWithNothingButSensorBuses) {
    StatusLine line({}, {});
    EXPECT_EQ(line.text({}, {}, kStart), "running");
}

}  // namespace
}  // namespace tribus::test::status_line_test
