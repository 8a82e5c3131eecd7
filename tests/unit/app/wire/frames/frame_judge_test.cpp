#include "app/wire/frames/frame_judge.h"

#include <chrono>

#include <gtest/gtest.h>

namespace tribus::test::frame_judge_test {
namespace {

using namespace std::chrono_literals;

ChannelFrame frame(bool failsafe = false) {
    ChannelFrame made;
    made.set(0, kCentrePulse);
    made.frame_lost = false;
    made.failsafe = failsafe;
    return made;
}

TEST(FrameJudge, SaysNothingWithoutTheDetectorsOfAnInput) {
    FrameJudge judge(std::nullopt);
    judge.bytes_came(5ms);
    EXPECT_FALSE(judge.judge(frame(), 5ms));
}

TEST(FrameJudge, SaysNothingWhereTheRecordingHasNoTimes) {
    FrameJudge judge(SupervisionSettings{});
    judge.bytes_came(std::nullopt);
    EXPECT_FALSE(judge.judge(frame(), std::nullopt));
}

TEST(FrameJudge, TellsTheCauseOfEachFrame) {
    FrameJudge judge(SupervisionSettings{});
    judge.bytes_came(5ms);
    EXPECT_EQ(judge.judge(frame(), 5ms)->state.cause, LinkCause::good);
    judge.bytes_came(12ms);
    const auto lost = judge.judge(frame(true), 12ms);
    EXPECT_EQ(lost->state.cause, LinkCause::radio_lost);
    EXPECT_EQ(lost->state.sign, RadioLossSign::failsafe_flag);
}

TEST(FrameJudge, TellsOnceWhyTheLinkWasLostBeforeAFrame) {
    FrameJudge judge(SupervisionSettings{});
    judge.bytes_came(5ms);
    judge.judge(frame(), 5ms);
    judge.bytes_came(300ms);
    const auto back = judge.judge(frame(), 300ms);
    ASSERT_TRUE(back->lost_before);
    EXPECT_EQ(back->lost_before->cause, LinkCause::wire_silent);
    EXPECT_EQ(back->lost_before->since, Instant(5ms));
    judge.bytes_came(307ms);
    EXPECT_FALSE(judge.judge(frame(), 307ms)->lost_before);
}

}  // namespace
}  // namespace tribus::test::frame_judge_test
