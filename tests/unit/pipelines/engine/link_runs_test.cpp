#include <gtest/gtest.h>

#include "tests/unit/pipelines/rules/supervised_link.h"

/// When a run of good frames begins, when a loss begins, and how a reload affects both.
namespace tribus::test::link::link_runs_test {
namespace {

constexpr PulseRange kUsual{Pulse::from_microseconds(900), Pulse::from_microseconds(2100)};

TEST(LinkRun, GoesOnOverFramesThatAreMarkedFrameLost) {
    const Link link = Link().moving(70ms).same(140ms, frame_lost(sticks())).moving(210ms);
    EXPECT_EQ(link.supervisor().run_start(), at(0ms));
}

TEST(LinkRun, GoesOnOverFramesThatAreNotPlausible) {
    const Link link =
        Link({.plausible = kUsual}).moving(70ms).same(140ms, sticks(2101)).moving(210ms);
    EXPECT_EQ(link.supervisor().run_start(), at(0ms));
}

TEST(LinkRun, BeginsAnewWhereTheGoodFrameBecomesOlderThanTheTimeout) {
    // The good frame of 63 ms is too old from 163 ms on.
    const Link link = Link().moving(70ms).same(161ms, frame_lost(sticks())).moving(300ms);
    EXPECT_EQ(link.supervisor().run_start(), at(0ms));
    const Link later = Link().moving(70ms).same(168ms, frame_lost(sticks())).moving(300ms);
    EXPECT_EQ(later.supervisor().run_start(), at(168ms));
}

TEST(LinkRun, BeginsAnewThereAlthoughMarkedFramesKeepTheLink) {
    const SupervisionSettings settings{.frame_lost_run = 500ms};
    const Link link = Link(settings).moving(70ms).same(273ms, frame_lost(sticks())).moving(350ms);
    EXPECT_TRUE(link.supervisor().first_run()) << "it was never lost";
    EXPECT_EQ(link.supervisor().run_start(), at(273ms));
    const Link soon = Link(settings).moving(70ms).same(84ms, frame_lost(sticks())).moving(350ms);
    EXPECT_EQ(soon.supervisor().run_start(), at(0ms));
}

TEST(LinkRun, ProvesALinkWithThreeGoodFramesAndNoFewer) {
    Link link = Link().same(7ms, sticks()).same(70ms, frame_lost(sticks())).same(77ms, sticks());
    EXPECT_FALSE(link.supervisor().has_proved(50ms, at(77ms))) << "two good frames";
    EXPECT_TRUE(link.supervisor().has_proved(0ms, at(77ms))) << "nothing has to be proved";
    link.same(84ms, sticks());
    EXPECT_TRUE(link.supervisor().has_proved(77ms, at(77ms)));
    EXPECT_FALSE(link.supervisor().has_proved(78ms, at(77ms)));
}

TEST(LinkRun, ProvesNothingWhileTheGoodFrameIsOlderThanTheTimeout) {
    const Link link =
        Link({.frame_lost_run = 500ms}).moving(70ms).same(170ms, frame_lost(sticks()));
    EXPECT_TRUE(link.supervisor().has_proved(50ms, at(163ms)));
    EXPECT_FALSE(link.supervisor().has_proved(50ms, at(163ms + 1ns)));
}

TEST(LinkCause, IsRadioLostSinceTheFirstFrameOfALossThatGoesOn) {
    const Link link = Link().moving(70ms).same(140ms, failsafe(sticks()));
    EXPECT_EQ(link.state(140ms).since, at(70ms));
}

TEST(LinkCause, KeepsTheSignThatALossBeganWith) {
    const ValueRule low{.channel = 2, .below = us(950)};
    const Link link =
        Link({.failsafe_when = {low}}).moving(70ms).same(77ms, sticks(900)).same(140ms, [] {
            return failsafe(sticks(900));
        }());
    EXPECT_EQ(link.state(140ms).sign, RadioLossSign::value_rule);
}

TEST(Frozen, MayBeLongerThanTheTimeoutAndDoesNotProlongIt) {
    const Link link = Link({.frozen = 500ms}).moving(70ms);  // the last at 63 ms
    EXPECT_TRUE(link.supervisor().alive(at(163ms - 1ns)));
    EXPECT_FALSE(link.supervisor().alive(at(163ms)));
}

TEST(Plausible, LooksAtAllEighteenChannels) {
    ChannelFrame frame = sticks();
    frame.set(16, us(1500));
    frame.set(17, us(2101));
    EXPECT_EQ(Link({.plausible = kUsual}).same(70ms, frame).cause(70ms), LinkCause::implausible);
}

TEST(ZeroGuard, BeginsAnewWhereALinkFallsSilentBeforeItWasEverGood) {
    ChannelFrame half = sticks();
    half.set(2, kRawZero);
    const Link link = Link({.raw_zero = kRawZero}).same(500ms, half).silence(5s).same(5900ms, half);
    EXPECT_EQ(link.cause(5900ms), LinkCause::implausible);
}

TEST(LinkAfterAReload, IsNotRevivedByALongerTimeout) {
    Link before = Link().moving(70ms);  // lost from 163 ms on
    LinkSupervisor after(SupervisionSettings{.timeout = 1s});
    after.continue_from(before.supervisor(), at(300ms));
    EXPECT_FALSE(after.alive(at(300ms)));
}

TEST(LinkAfterAReload, IsLostByAShorterTimeoutAtOnce) {
    Link before = Link({.timeout = 1s}).moving(70ms);
    LinkSupervisor after(SupervisionSettings{.timeout = 100ms});
    after.continue_from(before.supervisor(), at(150ms));
    EXPECT_TRUE(after.alive(at(163ms - 1ns)));
    EXPECT_FALSE(after.alive(at(163ms)));
}

TEST(LinkAfterAReload, ThatWatchesForStandingStillFromNowOnCountsFromNow) {
    Link before = Link().same(2s, sticks());
    LinkSupervisor after(SupervisionSettings{.frozen = 500ms});
    after.continue_from(before.supervisor(), at(2s));
    ChannelFrame frame = sticks();
    for (Instant now = at(2s); now < at(2490ms); now += kInterval) {
        frame.received = now;
        after.take(frame, now);
    }
    EXPECT_TRUE(after.alive(at(2500ms - 1ns)));
    EXPECT_FALSE(after.alive(at(2500ms)));
}

}  // namespace
}  // namespace tribus::test::link::link_runs_test
