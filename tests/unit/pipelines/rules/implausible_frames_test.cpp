#include <gtest/gtest.h>

#include "tests/unit/pipelines/rules/supervised_link.h"

/// Which value a link names of a frame that is not plausible.
namespace tribus::test::link::implausible_frames_test {
namespace {

constexpr PulseRange kUsual{Pulse::from_microseconds(900), Pulse::from_microseconds(2100)};

TEST(ImplausibleFrames, name_the_first_channel_outside_the_range) {
    const Link link = Link({.plausible = kUsual}).moving(70ms).same(84ms, sticks(2158));
    const ImplausibleFrames& implausible = link.supervisor().implausible();
    EXPECT_EQ(implausible.frames, 2U);
    EXPECT_EQ(implausible.at, at(77ms));
    EXPECT_EQ(implausible.channel, 2U);
    EXPECT_EQ(implausible.pulse, us(2158));
    EXPECT_EQ(implausible.plausible, kUsual);
}

TEST(ImplausibleFrames, name_a_raw_zero_behind_a_loss_without_a_range) {
    const Link link = Link({.raw_zero = kRawZero}).same(7ms, sticks(880));
    const ImplausibleFrames& implausible = link.supervisor().implausible();
    EXPECT_EQ(implausible.frames, 1U);
    EXPECT_EQ(implausible.channel, 2U);
    EXPECT_EQ(implausible.pulse, kRawZero);
    EXPECT_EQ(implausible.plausible, std::nullopt);
}

TEST(ImplausibleFrames, name_the_channel_outside_the_range_where_another_has_a_raw_zero) {
    ChannelFrame frame = sticks(2158);
    frame.set(0, kRawZero);
    const PulseRange wide{us(800), us(2100)};
    const Link link = Link({.plausible = wide, .raw_zero = kRawZero}).same(7ms, frame);
    EXPECT_EQ(link.supervisor().implausible().channel, 2U);
}

TEST(ImplausibleFrames, are_none_where_all_values_are_plausible) {
    const Link link = Link({.plausible = kUsual}).moving(70ms);
    EXPECT_EQ(link.supervisor().implausible().frames, 0U);
}

}  // namespace
}  // namespace tribus::test::link::implausible_frames_test
