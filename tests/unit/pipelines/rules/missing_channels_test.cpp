#include <gtest/gtest.h>

#include "tests/unit/pipelines/rules/supervised_link.h"

/// A sender that leaves out channels that it sent before.
namespace tribus::test::link::missing_channels_test {
namespace {

constexpr SupervisionSettings kMeantAfterHalfASecond{.fewer_channels_after = 500ms};

ChannelFrame only_the_first(std::size_t count) {
    ChannelFrame frame = sticks();
    for (std::size_t channel = count; channel < kChannelCount; ++channel) {
        frame.remove(channel);
    }
    return frame;
}

TEST(MissingChannels, AreALossWithTheFirstFrame) {
    const Link link = Link(kMeantAfterHalfASecond).moving(70ms).same(77ms, only_the_first(15));
    EXPECT_EQ(link.cause(77ms), LinkCause::channels_missing);
    EXPECT_FALSE(link.supervisor().alive(at(77ms)));
    EXPECT_EQ(link.supervisor().lost_at(), at(70ms));
}

TEST(MissingChannels, ThatAreBackBeginANewRun) {
    const Link link =
        Link(kMeantAfterHalfASecond).moving(70ms).same(140ms, only_the_first(1)).moving(210ms);
    EXPECT_EQ(link.cause(210ms), LinkCause::good);
    EXPECT_EQ(link.supervisor().run_start(), at(140ms));
}

TEST(MissingChannels, AreMeantWhenTheSameOnesStayedAwayForLongEnough) {
    Link link = Link(kMeantAfterHalfASecond).moving(70ms);
    link.same(567ms, only_the_first(4));
    EXPECT_EQ(link.cause(567ms), LinkCause::channels_missing);
    link.same(581ms, only_the_first(4));
    EXPECT_EQ(link.cause(581ms), LinkCause::good);
    EXPECT_EQ(link.supervisor().run_start(), at(70ms));
    EXPECT_EQ(link.supervisor().control().absent(), only_the_first(4).absent());
}

TEST(MissingChannels, ThatAreOthersEachTimeAreNeverMeant) {
    const Link link = Link(kMeantAfterHalfASecond).moving(70ms).frames(5s, [](std::int64_t n) {
        return only_the_first(n % 2 == 0 ? 4 : 5);
    });
    EXPECT_EQ(link.cause(5s), LinkCause::channels_missing);
}

TEST(MissingChannels, CountTheirTimeAnewBehindAFrameWithAll) {
    Link link = Link(kMeantAfterHalfASecond).moving(70ms);
    link.same(490ms, only_the_first(4)).same(497ms, sticks()).same(980ms, only_the_first(4));
    EXPECT_EQ(link.cause(980ms), LinkCause::channels_missing);
}

TEST(MissingChannels, AreNoLossOfASenderThatNeverHadThem) {
    EXPECT_EQ(Link(kMeantAfterHalfASecond).same(70ms, only_the_first(4)).cause(70ms),
              LinkCause::good);
}

TEST(MissingChannels, AreNeverMeantIfFramesHaveNone) {
    const Link never = Link(kMeantAfterHalfASecond).same(5s, only_the_first(0));
    EXPECT_EQ(never.cause(5s), LinkCause::channels_missing);
    EXPECT_FALSE(never.supervisor().ever_good());
    const Link lost = Link(kMeantAfterHalfASecond).moving(70ms).same(5s, only_the_first(0));
    EXPECT_EQ(lost.cause(5s), LinkCause::channels_missing);
    EXPECT_FALSE(lost.supervisor().alive(at(5s)));
}

/// A DBC signal with `optional = true` whose sender has no value for a while.
TEST(MissingChannels, ThatAreOptionalAreNoLossHoweverTheyComeAndGo) {
    constexpr SupervisionSettings kOptionalEighth{.fewer_channels_after = 500ms,
                                                  .optional_channels = 1U << 7U};
    for (const Duration each : {100ms, 200ms, 500ms, 1000ms, 2000ms}) {
        Link link(kOptionalEighth);
        for (Duration time = each; time < 20s; time += each) {
            const bool absent = time / each % 2 == 0;
            link.frames(time, [absent](std::int64_t) {
                ChannelFrame frame = sticks();
                if (absent) {
                    frame.remove(7);
                }
                return frame;
            });
            ASSERT_EQ(link.cause(time), LinkCause::good) << time.count();
            EXPECT_EQ(link.supervisor().run_start(), at(0ms));
            EXPECT_EQ(link.supervisor().control().has(7), !absent);
        }
    }
}

/// A box of buttons: all of its signals are optional.
TEST(MissingChannels, ThatAreAllOptionalAreNoLossTogether) {
    Link link({.optional_channels = (1U << kChannelCount) - 1});
    link.moving(70ms).same(5s, only_the_first(0));
    EXPECT_EQ(link.cause(5s), LinkCause::good);
    EXPECT_FALSE(link.supervisor().control().has_any());
}

TEST(MissingChannels, ThatAreNotOptionalAreALossBesideThoseThatAre) {
    Link link({.fewer_channels_after = 500ms, .optional_channels = 1U << 7U});
    link.moving(70ms).frames(490ms, [](std::int64_t n) {
        ChannelFrame frame = only_the_first(15);
        if (n % 2 == 0) {
            frame.remove(7);
        }
        return frame;
    });
    EXPECT_EQ(link.cause(490ms), LinkCause::channels_missing);
}

}  // namespace
}  // namespace tribus::test::link::missing_channels_test
