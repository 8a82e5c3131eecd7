#include "core/channel_frame.h"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>

namespace tribus::channel_frame_test {
namespace {

constexpr Pulse kPulse = Pulse::from_microseconds(1234);

TEST(ChannelFrame, StartsWithoutAChannelAndInFailsafe) {
    const ChannelFrame frame;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        EXPECT_FALSE(frame.has(channel));
        EXPECT_EQ(frame.channel(channel), std::nullopt);
    }
    EXPECT_TRUE(frame.failsafe);
    EXPECT_TRUE(frame.frame_lost);
    EXPECT_FALSE(frame.good());
}

TEST(ChannelFrame, IsGoodOnlyWithoutEitherFlag) {
    ChannelFrame frame;
    for (const bool lost : {false, true}) {
        for (const bool failsafe : {false, true}) {
            frame.frame_lost = lost;
            frame.failsafe = failsafe;
            EXPECT_EQ(frame.good(), !lost && !failsafe);
        }
    }
}

TEST(ChannelFrame, SettingOneChannelLeavesTheOthersAlone) {
    for (std::size_t set = 0; set < kChannelCount; ++set) {
        ChannelFrame frame;
        frame.set(set, kPulse);
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            ASSERT_EQ(frame.has(channel), channel == set);
            ASSERT_EQ(frame.channel_or(channel, kCentrePulse),
                      channel == set ? kPulse : kCentrePulse);
        }
    }
}

TEST(ChannelFrame, AZeroPulseIsAChannelAndNotAnAbsence) {
    ChannelFrame frame;
    frame.set(0, Pulse{});
    EXPECT_EQ(frame.channel(0), Pulse{});
}

TEST(ChannelFrame, RemovingAChannelMakesItAbsent) {
    ChannelFrame frame;
    frame.set(4, kPulse);
    frame.set(5, kPulse);
    frame.remove(4);
    EXPECT_EQ(frame.channel(4), std::nullopt);
    EXPECT_EQ(frame.channel(5), kPulse);
}

TEST(ChannelFrame, SettingAnOptionalSetsOrRemoves) {
    ChannelFrame frame;
    frame.set(2, std::optional(kPulse));
    EXPECT_EQ(frame.channel(2), kPulse);
    frame.set(2, std::optional<Pulse>{});
    EXPECT_FALSE(frame.has(2));
}

TEST(ChannelFrame, ContentIsChannelsAndFlagsAndNotOrigin) {
    ChannelFrame one;
    one.set(3, kPulse);
    ChannelFrame other = one;
    other.source = 1;
    other.sequence = 77;
    other.received = Instant(std::chrono::milliseconds(5));
    EXPECT_TRUE(one.same_content(other));

    ChannelFrame flagged = one;
    flagged.failsafe = false;
    EXPECT_FALSE(one.same_content(flagged));
    flagged = one;
    flagged.frame_lost = false;
    EXPECT_FALSE(one.same_content(flagged));

    ChannelFrame moved = one;
    moved.set(3, Pulse::from_microseconds(1235));
    EXPECT_FALSE(one.same_content(moved));
}

TEST(ChannelFrame, AnAbsentChannelIsNotTheSameAsOneAtZero) {
    ChannelFrame zero;
    zero.set(0, Pulse{});
    EXPECT_FALSE(zero.same_content(ChannelFrame{}));
}

TEST(ChannelFrame, RemovedAndNeverSetAreTheSameContent) {
    ChannelFrame frame;
    frame.set(0, kPulse);
    frame.remove(0);
    EXPECT_TRUE(frame.same_content(ChannelFrame{}));
}

}  // namespace
}  // namespace tribus::channel_frame_test
