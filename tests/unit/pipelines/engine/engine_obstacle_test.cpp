#include <cstddef>

#include <gtest/gtest.h>

#include "pipelines/engine/health_watch.h"
#include "tests/unit/pipelines/engine/engine_bench.h"

/// Frames that cannot be sent: the output reports this, whatever its inputs send.
namespace tribus::test::serial::engine_obstacle_test {
namespace {

/// In control from 0 ms on, with a lamp and an alarm.
class Obstacle : public testing::Test {
  protected:
    explicit Obstacle(FailsafeSettings failsafe = {})
        : bench_(list(ibus_input()), list(sbus_output({0}, failsafe)),
                 {{.role = LineRole::link, .outputs = {0}},
                  {.role = LineRole::failsafe, .outputs = {0}},
                  {.role = LineRole::channel_switch,
                   .outputs = {0},
                   .rule = {.channel = 0, .above = us(1700)}}}) {
        bench_.ibus_run(0, at(0ms), at(1000ms), us(1800));
    }
    Output& output() { return bench_.engine().output(0); }
    bool shown(std::size_t line) {
        return (bench_.engine().shown_on_lines().on & line_bit(line)) != 0;
    }
    double fact(OutputFact fact) {
        return HealthWatch(1, 1).number(bench_.engine(), 0, fact, at(1000ms)).value_or(-1);
    }

    Bench bench_;
};

TEST_F(Obstacle, CountsAtOnceForADeviceThatIsGone) {
    output().dropped_lost();
    EXPECT_EQ(output().state(at(1000ms)).stage, OutputStage::cannot_send);
    EXPECT_EQ(output().state(at(1000ms)).obstacle, SendObstacle::device);
}

TEST_F(Obstacle, CountsAtOnceForABusThatTakesNothing) {
    output().dropped_unavailable();
    EXPECT_EQ(output().state(at(1000ms)).stage, OutputStage::cannot_send);
    EXPECT_EQ(output().state(at(1000ms)).obstacle, SendObstacle::bus);
}

TEST_F(Obstacle, NamesNoInputAsInControl) {
    output().dropped_unavailable();
    EXPECT_EQ(output().state(at(1000ms)).input, kNoInput);
}

TEST_F(Obstacle, IsNotASingleFrameThatFindsTheOneBeforeStillWaiting) {
    for (int frame = 0; frame < 9; ++frame) {
        output().dropped_busy();
    }
    EXPECT_EQ(output().stage(), OutputStage::control);
}

TEST_F(Obstacle, IsTenSuchFramesInARow) {
    for (int frame = 0; frame < 10; ++frame) {
        output().dropped_busy();
    }
    EXPECT_EQ(output().state(at(1000ms)).obstacle, SendObstacle::busy);
}

TEST_F(Obstacle, IsNotTenSuchFramesWithOneBetweenThatLeft) {
    for (int frame = 0; frame < 30; ++frame) {
        output().dropped_busy();
        if (frame % 9 == 8) {
            output().written();
        }
    }
    EXPECT_EQ(output().stage(), OutputStage::control);
}

TEST_F(Obstacle, EndsWithTheFirstFrameThatLeaves) {
    output().dropped_unavailable();
    output().written();
    EXPECT_EQ(output().stage(), OutputStage::control);
}

TEST_F(Obstacle, EndsWithItsDeviceAndNotWithAnotherObstacle) {
    output().set_device_present(false);
    output().set_device_present(true);
    EXPECT_EQ(output().stage(), OutputStage::control);
    output().dropped_unavailable();
    output().set_device_present(true);
    EXPECT_EQ(output().stage(), OutputStage::cannot_send);
}

TEST_F(Obstacle, TurnsTheLampOffTheAlarmOnAndTheSwitchOff) {
    ASSERT_TRUE(shown(0) && !shown(1) && shown(2));
    output().dropped_unavailable();
    EXPECT_FALSE(shown(0));
    EXPECT_TRUE(shown(1));
    EXPECT_FALSE(shown(2));
}

TEST_F(Obstacle, IsToldAsAValueAndAsFailsafe) {
    EXPECT_EQ(fact(OutputFact::cannot_send), 0);
    EXPECT_EQ(fact(OutputFact::failsafe), 0);
    output().dropped_unavailable();
    EXPECT_EQ(fact(OutputFact::cannot_send), 1);
    EXPECT_EQ(fact(OutputFact::failsafe), 1);
}

class ObstacleOfASilentOne : public Obstacle {
  protected:
    ObstacleOfASilentOne() : Obstacle({.action = FailsafeAction::silence}) {
        bench_.loop().run_until(at(2000ms));
    }
};

/// Nobody knows whether the bus would accept a frame again.
TEST_F(ObstacleOfASilentOne, LastsNoLongerThanThereIsSomethingToSend) {
    output().dropped_unavailable();
    bench_.loop().run_until(at(2100ms));
    EXPECT_EQ(output().stage(), OutputStage::failsafe);
}

TEST_F(ObstacleOfASilentOne, StaysWhileItsDeviceIsGone) {
    output().set_device_present(false);
    bench_.loop().run_until(at(2100ms));
    EXPECT_EQ(output().stage(), OutputStage::cannot_send);
}

}  // namespace
}  // namespace tribus::test::serial::engine_obstacle_test
