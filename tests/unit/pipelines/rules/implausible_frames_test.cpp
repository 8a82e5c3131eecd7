#include <gtest/gtest.h>

#include "tests/unit/pipelines/rules/supervised_link.h"

/// Which value a link names of a frame that is not plausible.
namespace tribus::test::link::implausible_frames_test {
namespace {

constexpr PulseRange kUsual{Pulse::from_microseconds(900), Pulse::from_microseconds(2100)};

TEST(ImplausibleFrames, NameTheFirstChannelOutsideTheRange) {
    const Link link = Link({.plausible = kUsual}).moving(70ms).same(84ms, sticks(2158));
    const ImplausibleFrames& implausible = link.supervisor().implausible();
    EXPECT_EQ(implausible.frames, 2U);
    EXPECT_EQ(implausible.at, at(77ms));
    EXPECT_EQ(implausible.channel, 2U);
    EXPECT_EQ(implausible.pulse, us(2158));
    EXPECT_EQ(implausible.plausible, kUsual);
}

TEST(ImplausibleFrames, NameARawZeroBehindALossWithoutARange) {
    const Link link = Link({.raw_zero = kRawZero}).same(7ms, sticks(880));
    const ImplausibleFrames& implausible = link.supervisor().implausible();
    EXPECT_EQ(implausible.frames, 1U);
    EXPECT_EQ(implausible.channel, 2U);
    EXPECT_EQ(implausible.pulse, kRawZero);
    EXPECT_EQ(implausible.plausible, std::nullopt);
}

TEST(ImplausibleFrames, NameTheChannelOutsideTheRangeWhereAnotherHasARawZero) {
    ChannelFrame frame = sticks(2158);
    frame.set(0, kRawZero);
    const PulseRange wide{us(800), us(2100)};
    const Link link = Link({.plausible = wide, .raw_zero = kRawZero}).same(7ms, frame);
    EXPECT_EQ(link.supervisor().implausible().channel, 2U);
}

TEST(ImplausibleFrames, AreNoneWhereAllValuesArePlausible) {
    const Link link = Link({.plausible = kUsual}).moving(70ms);
    EXPECT_EQ(link.supervisor().implausible().frames, 0U);
}

}  // namespace
}  // namespace tribus::test::link::implausible_frames_test
