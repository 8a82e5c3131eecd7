#include "pipelines/rules/link_supervisor.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>

#include "tests/unit/pipelines/rules/supervised_link.h"

namespace tribus::test::link::link_supervisor_test {
namespace {

TEST(LinkCause, IsNeverSeenForALinkWithoutAByte) {
    EXPECT_EQ(Link().cause(10s), LinkCause::never_seen);
}

TEST(LinkCause, IsGarbledSinceTheFirstByteForALinkWithNoFrameFromTheStart) {
    const Link link = Link().silence(50ms).bytes(500ms);
    EXPECT_EQ(link.cause(500ms), LinkCause::garbled);
    EXPECT_EQ(link.state(500ms).since, at(50ms));
}

TEST(LinkCause, IsGoodForGoodFramesSinceTheRunBegan) {
    const Link link = Link().silence(20ms).moving(500ms);
    EXPECT_EQ(link.cause(500ms), LinkCause::good);
    EXPECT_EQ(link.state(500ms).since, at(20ms));
}

TEST(LinkCause, IsWireSilentForAPulledWireSinceTheLastByteAndFromTheTimeoutOn) {
    const Link link = Link().moving(70ms);  // the last at 63 ms
    EXPECT_EQ(link.cause(163ms - 1ns), LinkCause::good);
    EXPECT_EQ(link.cause(163ms), LinkCause::wire_silent);
    EXPECT_EQ(link.state(163ms).since, at(63ms));
}

TEST(LinkCause, IsGarbledSinceTheLastFrameForAWireThatPicksUpNoise) {
    const Link link = Link().moving(70ms).bytes(400ms);
    EXPECT_EQ(link.cause(400ms), LinkCause::garbled);
    EXPECT_EQ(link.state(400ms).since, at(63ms));
}

TEST(LinkCause, TurnsFromGarbledToWireSilentATimeoutAfterTheLastByte) {
    const Link link = Link().moving(70ms).bytes(400ms);  // the last byte at 399 ms
    EXPECT_EQ(link.cause(499ms - 1ns), LinkCause::garbled);
    EXPECT_EQ(link.cause(499ms), LinkCause::wire_silent);
}

TEST(LinkCause, IsRadioLostAtOnceForAFailsafeFlagAndSaysHowItShows) {
    const Link link = Link().moving(70ms).same(77ms, failsafe(sticks()));
    EXPECT_EQ(link.cause(70ms), LinkCause::radio_lost);
    EXPECT_EQ(link.state(70ms).sign, RadioLossSign::failsafe_flag);
    EXPECT_EQ(link.state(70ms).since, at(70ms));
}

TEST(LinkCause, IsWireSilentForAReceiverInFailsafeThatIsThenUnplugged) {
    const Link link = Link().moving(70ms).same(140ms, failsafe(sticks()));
    EXPECT_EQ(link.cause(300ms), LinkCause::wire_silent);
}

TEST(LinkCause, AFailsafeFlagThatIsSwitchedOffDoesNotCount) {
    const Link link = Link({.failsafe_flag = false}).moving(70ms).same(210ms, [] {
        ChannelFrame frame = sticks();
        frame.failsafe = true;
        return frame;
    }());
    EXPECT_EQ(link.cause(210ms), LinkCause::good);
}

TEST(LinkCause, AFrameLostFlagThatIsSwitchedOffDoesNotCount) {
    const Link link = Link({.frame_lost_flag = false}).same(2s, frame_lost(sticks()));
    EXPECT_EQ(link.cause(2s), LinkCause::good);
    EXPECT_TRUE(link.supervisor().control().good());
}

TEST(FrameLostRun, IsALossAfterTheTimeoutWhereNothingElseIsSaid) {
    const Link link = Link().moving(70ms).same(400ms, frame_lost(sticks()));
    EXPECT_EQ(link.cause(163ms - 1ns), LinkCause::good);
    EXPECT_EQ(link.cause(400ms), LinkCause::radio_lost);
    EXPECT_EQ(link.state(400ms).sign, RadioLossSign::frame_lost_run);
    EXPECT_EQ(link.state(400ms).since, at(70ms));
}

TEST(FrameLostRun, MayBeLongerThanTheTimeoutWhileTheWireIsThere) {
    const Link link =
        Link({.frame_lost_run = 500ms}).moving(70ms).same(560ms, frame_lost(sticks()));
    EXPECT_EQ(link.cause(560ms), LinkCause::good);
    EXPECT_TRUE(link.supervisor().control().frame_lost) << "old values say that they are";
    EXPECT_EQ(link.cause(563ms), LinkCause::radio_lost);
}

TEST(FrameLostRun, ThatIsLongerEndsWithTheTimeoutWhereTheWireFallsSilent) {
    const Link link =
        Link({.frame_lost_run = 500ms}).moving(70ms).same(105ms, frame_lost(sticks()));
    EXPECT_EQ(link.cause(198ms - 1ns), LinkCause::good);  // the last at 98 ms
    EXPECT_EQ(link.cause(198ms), LinkCause::wire_silent);
}

TEST(FrameLostRun, DoesNotBringALostLinkBack) {
    const Link link =
        Link({.frame_lost_run = 5s}).moving(70ms).silence(400ms).same(500ms, frame_lost(sticks()));
    EXPECT_FALSE(link.supervisor().alive(at(500ms)));
}

TEST(FrameLostRatio, AboveNineInTenIsALoss) {
    const auto lossy = [](std::int64_t good_each) {
        return Link().moving(70ms).frames(3s, [=](std::int64_t n) {
            return n % good_each == 0 ? sticks(1200 + n % 100) : frame_lost(sticks());
        });
    };
    EXPECT_EQ(lossy(10).cause(3s), LinkCause::good);
    EXPECT_EQ(lossy(12).cause(3s), LinkCause::radio_lost);
    EXPECT_EQ(lossy(12).state(3s).sign, RadioLossSign::frame_lost_ratio);
}

TEST(FrameLostRatio, AtOneIsOff) {
    const Link link = Link({.frame_lost_ratio = 1}).frames(3s, [](std::int64_t n) {
        return n % 13 == 0 ? sticks(1200 + n % 100) : frame_lost(sticks());
    });
    EXPECT_EQ(link.cause(3s), LinkCause::good);
}

TEST(FrameLostRatio, LetsTheLinkComeBackAtHalfOfEveryLimit) {
    for (int percent = 1; percent < 100; ++percent) {
        const auto half_of_it_lost = [=](std::int64_t n) {
            const bool lost = 37 * n % 100 < percent / 2;  // spread over each hundred frames
            return lost ? frame_lost(sticks()) : sticks(1200 + n % 100);
        };
        Link link({.frame_lost_ratio = percent / 100.0});
        link.same(800ms, frame_lost(sticks()));
        EXPECT_EQ(link.state(800ms).sign, RadioLossSign::frame_lost_ratio);
        EXPECT_EQ(link.frames(2s, half_of_it_lost).cause(2s), LinkCause::good) << percent;
    }
}

TEST(FrameLostRatio, ThatWasTooHighMustFallWellBelowBeforeTheLinkIsGoodAgain) {
    // One good frame in eleven means 90 or 91 lost frames in a hundred: the ratio changes around
    // the limit.
    const auto eleventh = [](std::int64_t n) {
        return n % 11 == 0 ? sticks(1200 + n % 100) : frame_lost(sticks());
    };
    std::uint64_t turns = 0;
    LinkCause latest = LinkCause::good;
    Link link;
    link.moving(100ms);
    for (Duration until = 100ms; until < 10s; until += 7ms) {
        link.frames(until, [&, n = until / 7ms](std::int64_t) { return eleventh(n); });
        turns += link.cause(until) != latest ? 1U : 0U;
        latest = link.cause(until);
    }
    EXPECT_EQ(turns, 1U);
}

TEST(FrameLostRatio, IsOverSoonAfterTheFramesAreGoodAgain) {
    const auto lossy_until_a_second = [](std::int64_t n) {
        return n % 12 == 0 ? sticks(1200 + n % 100) : frame_lost(sticks());
    };
    const Link link = Link().frames(2s, lossy_until_a_second).moving(2100ms);
    EXPECT_EQ(link.cause(2100ms), LinkCause::good);
}

TEST(ValueRules, SayLossBelowAboveOrBetween) {
    const auto cause_with = [](ValueRule rule, std::int64_t third) {
        return Link({.failsafe_when = {rule}}).same(70ms, sticks(third)).cause(70ms);
    };
    const ValueRule below{.channel = 2, .below = us(950)};
    EXPECT_EQ(cause_with(below, 949), LinkCause::radio_lost);
    EXPECT_EQ(cause_with(below, 950), LinkCause::good);
    const ValueRule above{.channel = 2, .above = us(2050)};
    EXPECT_EQ(cause_with(above, 2051), LinkCause::radio_lost);
    EXPECT_EQ(cause_with(above, 2050), LinkCause::good);
    const ValueRule between{.channel = 2, .between = PulseRange{us(990), us(994)}};
    EXPECT_EQ(cause_with(between, 989), LinkCause::good);
    EXPECT_EQ(cause_with(between, 990), LinkCause::radio_lost);
    EXPECT_EQ(cause_with(between, 994), LinkCause::radio_lost);
    EXPECT_EQ(cause_with(between, 995), LinkCause::good);
}

TEST(ValueRules, SayNothingOfAChannelThatIsAbsent) {
    ChannelFrame frame = sticks();
    frame.remove(2);
    const ValueRule below{.channel = 2, .below = us(950)};
    EXPECT_EQ(Link({.failsafe_when = {below}}).same(70ms, frame).cause(70ms), LinkCause::good);
}

TEST(ValueRules, AllZeroNeedsEveryChannelAtTheZeroOfTheWire) {
    const SupervisionSettings settings{
        .failsafe_when = {{.all_zero = true}}, .raw_zero = kRawZero, .zero_guard = 0ms};
    ChannelFrame almost = zeros();
    almost.set(15, us(881));
    EXPECT_EQ(Link(settings).same(70ms, zeros()).cause(70ms), LinkCause::radio_lost);
    EXPECT_EQ(Link(settings).same(70ms, zeros()).state(70ms).sign, RadioLossSign::value_rule);
    EXPECT_EQ(Link(settings).same(70ms, almost).cause(70ms), LinkCause::good);
}

TEST(Frozen, NoChangeOfAnyBitForSoLongIsALossSinceTheLastChange) {
    const Link link = Link({.frozen = 500ms}).moving(1s).same(2s, sticks(1000));
    EXPECT_EQ(link.cause(1501ms - 1ns), LinkCause::good);  // still since 1001 ms
    EXPECT_EQ(link.cause(1501ms), LinkCause::stale);
    EXPECT_EQ(link.state(1501ms).since, at(1001ms));
}

TEST(Frozen, ASingleEighthOfAMicrosecondIsAChange) {
    const Link link = Link({.frozen = 500ms}).frames(3s, [](std::int64_t n) {
        ChannelFrame frame = sticks();
        frame.set(7, Pulse::from_eighths(12000 + n % 2));
        return frame;
    });
    EXPECT_EQ(link.cause(3s), LinkCause::good);
}

TEST(Frozen, AFlagThatChangesIsNoChangeOfTheValues) {
    const Link link = Link({.frozen = 500ms}).frames(490ms, [](std::int64_t n) {
        return n % 2 == 0 ? sticks() : frame_lost(sticks());
    });
    EXPECT_EQ(link.cause(499ms), LinkCause::good);
    EXPECT_EQ(link.cause(500ms), LinkCause::stale);
}

TEST(Frozen, AnImplausibleFrameBetweenFramesThatDoNotChangeIsNoChange) {
    const SupervisionSettings settings{.frozen = 500ms, .plausible = PulseRange{us(900), us(2100)}};
    const Link link = Link(settings)
                          .same(350ms, sticks(1200))
                          .same(357ms, sticks(2101))  // damaged, although its sum is right
                          .same(600ms, sticks(1200));
    EXPECT_EQ(link.cause(500ms - 1ns), LinkCause::good);
    EXPECT_EQ(link.cause(600ms), LinkCause::stale);
    EXPECT_EQ(link.state(600ms).since, at(0ms));
}

TEST(Frozen, ValuesThatComeBackAfterImplausibleOnesForTheTimeoutAreNew) {
    const SupervisionSettings settings{.frozen = 500ms, .plausible = PulseRange{us(900), us(2100)}};
    const auto back_after = [&](std::chrono::milliseconds implausible) {
        return Link(settings)
            .same(350ms, sticks(1200))
            .same(350ms + implausible, sticks(2101))
            .same(600ms, sticks(1200));
    };
    EXPECT_EQ(back_after(112ms).cause(600ms), LinkCause::good);  // 105 ms from first to last
    EXPECT_EQ(back_after(105ms).cause(600ms), LinkCause::stale);
}

TEST(Frozen, ValuesThatComeBackAfterAnImplausibleFrameAndSilenceAreNotNew) {
    const SupervisionSettings settings{.frozen = 500ms, .plausible = PulseRange{us(900), us(2100)}};
    const Link link = Link(settings)
                          .same(350ms, sticks(1200))
                          .same(357ms, sticks(2101))
                          .silence(490ms)
                          .same(600ms, sticks(1200));
    EXPECT_EQ(link.cause(600ms), LinkCause::stale);
}

TEST(Frozen, IsOffWhereNobodyAskedForIt) {
    EXPECT_EQ(Link().same(60s, sticks()).cause(60s), LinkCause::good);
}

TEST(Frozen, ALinkThatMovesAgainBeginsItsRunAnew) {
    const Link link = Link({.frozen = 500ms}).moving(1s).same(2s, sticks(1000)).moving(2100ms);
    EXPECT_EQ(link.cause(2100ms), LinkCause::good);
    EXPECT_FALSE(link.supervisor().first_run());
    EXPECT_EQ(link.state(2100ms).since, at(2002ms));
}

TEST(Plausible, AFrameOutsideOfTheRangeKeepsTheValuesOfTheOneBeforeAndMarksThem) {
    const SupervisionSettings settings{.plausible = PulseRange{us(900), us(2100)}};
    const Link link = Link(settings).same(70ms, sticks(1200)).same(77ms, sticks(2101));
    EXPECT_EQ(link.cause(77ms), LinkCause::good);
    EXPECT_EQ(link.supervisor().control().channel(2), us(1200));
    EXPECT_TRUE(link.supervisor().control().frame_lost);
}

TEST(Plausible, NothingButFramesOutsideOfTheRangeIsALossAfterTheTimeout) {
    const SupervisionSettings settings{.plausible = PulseRange{us(900), us(2100)}};
    const Link link = Link(settings).same(70ms, sticks(1200)).same(400ms, sticks(899));
    EXPECT_EQ(link.cause(163ms - 1ns), LinkCause::good);
    EXPECT_EQ(link.cause(400ms), LinkCause::implausible);
    EXPECT_EQ(link.state(400ms).since, at(70ms));
}

TEST(ZeroGuard, AReceiverWhoseFlagClears400MsBeforeItsChannelsAreBackIsNotBelieved) {
    // FrSky X8R; ArduPilot issue 9400, PX4 issue 10571.
    ChannelFrame half = sticks();
    half.set(2, kRawZero);
    const Link link = Link({.raw_zero = kRawZero})
                          .moving(1s)
                          .same(2s, failsafe(zeros()))
                          .same(2400ms, half)
                          .moving(2500ms);
    Link during = Link({.raw_zero = kRawZero});
    during.moving(1s).same(2s, failsafe(zeros())).same(2400ms, half);
    EXPECT_EQ(during.cause(2400ms), LinkCause::implausible);
    EXPECT_EQ(link.cause(2500ms), LinkCause::good);
    EXPECT_EQ(link.state(2500ms).since, at(2401ms));
}

TEST(ZeroGuard, EndsSoThatAChannelThatRestsAtZeroCostsNoMoreThanItsTime) {
    ChannelFrame resting = sticks();
    resting.set(9, kRawZero);
    const SupervisionSettings settings{.raw_zero = kRawZero};
    EXPECT_EQ(Link(settings).same(994ms, resting).cause(994ms), LinkCause::implausible);
    const Link link = Link(settings).same(3s, resting);
    EXPECT_EQ(link.cause(3s), LinkCause::good);
    EXPECT_EQ(link.state(3s).since, at(1001ms));
}

TEST(ZeroGuard, DoesNotMindAZeroInTheMidstOfGoodFrames) {
    ChannelFrame low = sticks();
    low.set(2, kRawZero);
    const Link link = Link({.raw_zero = kRawZero}).moving(2s).same(3s, low);
    EXPECT_EQ(link.cause(3s), LinkCause::good);
    EXPECT_EQ(link.supervisor().control().channel(2), kRawZero);
}

TEST(ZeroGuard, BeginsAnewAfterEachLoss) {
    ChannelFrame half = sticks();
    half.set(2, kRawZero);
    for (const bool by_flag : {false, true}) {
        Link link({.raw_zero = kRawZero});
        link.moving(2s);
        by_flag ? link.same(3s, failsafe(sticks())) : link.silence(3s);
        link.same(3900ms, half);
        EXPECT_EQ(link.cause(3900ms), LinkCause::implausible) << by_flag;
    }
}

TEST(ZeroGuard, IsOffWithoutChannels) {
    ChannelFrame half = sticks();
    half.set(2, kRawZero);
    const Link link = Link({.raw_zero = kRawZero, .zero_guard = 0ms}).same(70ms, half);
    EXPECT_EQ(link.cause(70ms), LinkCause::good);
}

/// With time stamps of a CAN socket: the first frame came when the link had been lost for 100 ms.
TEST(LinkAbsence, InWhichFramesCameAfterALossIsALossSinceThat) {
    LinkSupervisor link({.timeout = 200ms});
    for (const Duration when : {0ms, 7ms, 14ms, 314ms, 321ms}) {
        ChannelFrame frame = sticks();
        frame.received = at(when);
        link.take(frame, at(when));
    }
    link.was_away(at(100ms), at(330ms));
    EXPECT_EQ(link.lost_at(), at(214ms));
}

/// With time stamps of a CAN socket, but nobody read the frames, so nobody had control.
TEST(LinkAbsence, InWhichFramesWentOnIsALossAllTheSame) {
    LinkSupervisor link({.timeout = 200ms});
    for (Duration when{}; when < 330ms; when += 7ms) {
        ChannelFrame frame = sticks();
        frame.received = at(when);
        link.take(frame, at(when));
    }
    link.was_away(at(100ms), at(330ms));
    EXPECT_EQ(link.lost_at(), at(300ms));
}

ChannelFrame without(std::size_t channel) {
    ChannelFrame frame = sticks();
    frame.remove(channel);
    return frame;
}

TEST(ChannelsMissing, IsTheCauseWhereFramesHaveNoneAtAllHoweverLongTheyCome) {
    ChannelFrame none = sticks();
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        none.remove(channel);
    }
    const Link link = Link().same(5s, none);
    EXPECT_EQ(link.cause(5s), LinkCause::channels_missing);
    EXPECT_FALSE(link.supervisor().ever_good());
}

TEST(ChannelsMissing, IsTheCauseSinceAChannelVanishedUntilItWasAwayOnPurpose) {
    Link link({.fewer_channels_after = 500ms});
    link.moving(70ms).same(560ms, without(4));
    EXPECT_EQ(link.cause(560ms), LinkCause::channels_missing);
    EXPECT_EQ(link.state(560ms).since, at(70ms));
    link.same(700ms, without(4));
    EXPECT_EQ(link.cause(700ms), LinkCause::good);
}

TEST(ChannelsMissing, CountsAnewWhereAnotherChannelIsAwayThanBefore) {
    Link link({.fewer_channels_after = 500ms});
    link.moving(70ms).same(420ms, without(4)).same(840ms, without(5));
    EXPECT_EQ(link.cause(840ms), LinkCause::channels_missing);
}

}  // namespace
}  // namespace tribus::test::link::link_supervisor_test
