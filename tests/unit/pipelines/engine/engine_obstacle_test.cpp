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

TEST_F(Obstacle, of_a_device_that_is_gone_counts_at_once) {
    output().dropped_lost();
    EXPECT_EQ(output().state(at(1000ms)).stage, OutputStage::cannot_send);
    EXPECT_EQ(output().state(at(1000ms)).obstacle, SendObstacle::device);
}

TEST_F(Obstacle, of_a_bus_that_takes_nothing_counts_at_once) {
    output().dropped_unavailable();
    EXPECT_EQ(output().state(at(1000ms)).stage, OutputStage::cannot_send);
    EXPECT_EQ(output().state(at(1000ms)).obstacle, SendObstacle::bus);
}

TEST_F(Obstacle, names_no_input_as_in_control) {
    output().dropped_unavailable();
    EXPECT_EQ(output().state(at(1000ms)).input, kNoInput);
}

TEST_F(Obstacle, is_not_a_single_frame_that_finds_the_one_before_still_waiting) {
    for (int frame = 0; frame < 9; ++frame) {
        output().dropped_busy();
    }
    EXPECT_EQ(output().stage(), OutputStage::control);
}

TEST_F(Obstacle, is_ten_such_frames_in_a_row) {
    for (int frame = 0; frame < 10; ++frame) {
        output().dropped_busy();
    }
    EXPECT_EQ(output().state(at(1000ms)).obstacle, SendObstacle::busy);
}

TEST_F(Obstacle, is_not_ten_such_frames_with_one_between_that_left) {
    for (int frame = 0; frame < 30; ++frame) {
        output().dropped_busy();
        if (frame % 9 == 8) {
            output().written();
        }
    }
    EXPECT_EQ(output().stage(), OutputStage::control);
}

TEST_F(Obstacle, ends_with_the_first_frame_that_leaves) {
    output().dropped_unavailable();
    output().written();
    EXPECT_EQ(output().stage(), OutputStage::control);
}

TEST_F(Obstacle, of_a_device_ends_with_the_device_and_not_with_another_obstacle) {
    output().set_device_present(false);
    output().set_device_present(true);
    EXPECT_EQ(output().stage(), OutputStage::control);
    output().dropped_unavailable();
    output().set_device_present(true);
    EXPECT_EQ(output().stage(), OutputStage::cannot_send);
}

TEST_F(Obstacle, turns_the_lamp_off_the_alarm_on_and_the_switch_off) {
    ASSERT_TRUE(shown(0) && !shown(1) && shown(2));
    output().dropped_unavailable();
    EXPECT_FALSE(shown(0));
    EXPECT_TRUE(shown(1));
    EXPECT_FALSE(shown(2));
}

TEST_F(Obstacle, is_told_as_a_value_and_as_failsafe) {
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
TEST_F(ObstacleOfASilentOne, lasts_no_longer_than_there_is_something_to_send) {
    output().dropped_unavailable();
    bench_.loop().run_until(at(2100ms));
    EXPECT_EQ(output().stage(), OutputStage::failsafe);
}

TEST_F(ObstacleOfASilentOne, stays_while_its_device_is_gone) {
    output().set_device_present(false);
    bench_.loop().run_until(at(2100ms));
    EXPECT_EQ(output().stage(), OutputStage::cannot_send);
}

}  // namespace
}  // namespace tribus::test::serial::engine_obstacle_test
