#include "pipelines/rules/link_supervisor.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>

#include "tests/unit/pipelines/rules/supervised_link.h"

namespace tribus::test::link::link_supervisor_test {
namespace {

TEST(LinkCause, of_a_link_without_a_byte_is_never_seen) {
    EXPECT_EQ(Link().cause(10s), LinkCause::never_seen);
}

TEST(LinkCause, of_a_link_with_bytes_but_no_frame_from_the_start_is_garbled_since_the_first) {
    const Link link = Link().silence(50ms).bytes(500ms);
    EXPECT_EQ(link.cause(500ms), LinkCause::garbled);
    EXPECT_EQ(link.state(500ms).since, at(50ms));
}

TEST(LinkCause, of_good_frames_is_good_since_the_run_began) {
    const Link link = Link().silence(20ms).moving(500ms);
    EXPECT_EQ(link.cause(500ms), LinkCause::good);
    EXPECT_EQ(link.state(500ms).since, at(20ms));
}

TEST(LinkCause, of_a_pulled_wire_is_wire_silent_since_the_last_byte_and_from_the_timeout_on) {
    const Link link = Link().moving(70ms);  // the last at 63 ms
    EXPECT_EQ(link.cause(163ms - 1ns), LinkCause::good);
    EXPECT_EQ(link.cause(163ms), LinkCause::wire_silent);
    EXPECT_EQ(link.state(163ms).since, at(63ms));
}

TEST(LinkCause, of_a_wire_that_picks_up_noise_is_garbled_since_the_last_frame) {
    const Link link = Link().moving(70ms).bytes(400ms);
    EXPECT_EQ(link.cause(400ms), LinkCause::garbled);
    EXPECT_EQ(link.state(400ms).since, at(63ms));
}

TEST(LinkCause, turns_from_garbled_to_wire_silent_a_timeout_after_the_last_byte) {
    const Link link = Link().moving(70ms).bytes(400ms);  // the last byte at 399 ms
    EXPECT_EQ(link.cause(499ms - 1ns), LinkCause::garbled);
    EXPECT_EQ(link.cause(499ms), LinkCause::wire_silent);
}

TEST(LinkCause, of_a_failsafe_flag_is_radio_lost_at_once_and_says_how_it_shows) {
    const Link link = Link().moving(70ms).same(77ms, failsafe(sticks()));
    EXPECT_EQ(link.cause(70ms), LinkCause::radio_lost);
    EXPECT_EQ(link.state(70ms).sign, RadioLossSign::failsafe_flag);
    EXPECT_EQ(link.state(70ms).since, at(70ms));
}

TEST(LinkCause, of_a_receiver_in_failsafe_that_is_then_unplugged_is_wire_silent) {
    const Link link = Link().moving(70ms).same(140ms, failsafe(sticks()));
    EXPECT_EQ(link.cause(300ms), LinkCause::wire_silent);
}

TEST(LinkCause, a_failsafe_flag_that_is_switched_off_does_not_count) {
    const Link link = Link({.failsafe_flag = false}).moving(70ms).same(210ms, [] {
        ChannelFrame frame = sticks();
        frame.failsafe = true;
        return frame;
    }());
    EXPECT_EQ(link.cause(210ms), LinkCause::good);
}

TEST(LinkCause, a_frame_lost_flag_that_is_switched_off_does_not_count) {
    const Link link = Link({.frame_lost_flag = false}).same(2s, frame_lost(sticks()));
    EXPECT_EQ(link.cause(2s), LinkCause::good);
    EXPECT_TRUE(link.supervisor().control().good());
}

TEST(FrameLostRun, is_a_loss_after_the_timeout_where_nothing_else_is_said) {
    const Link link = Link().moving(70ms).same(400ms, frame_lost(sticks()));
    EXPECT_EQ(link.cause(163ms - 1ns), LinkCause::good);
    EXPECT_EQ(link.cause(400ms), LinkCause::radio_lost);
    EXPECT_EQ(link.state(400ms).sign, RadioLossSign::frame_lost_run);
    EXPECT_EQ(link.state(400ms).since, at(70ms));
}

TEST(FrameLostRun, may_be_longer_than_the_timeout_while_the_wire_is_there) {
    const Link link =
        Link({.frame_lost_run = 500ms}).moving(70ms).same(560ms, frame_lost(sticks()));
    EXPECT_EQ(link.cause(560ms), LinkCause::good);
    EXPECT_TRUE(link.supervisor().control().frame_lost) << "old values say that they are";
    EXPECT_EQ(link.cause(563ms), LinkCause::radio_lost);
}

TEST(FrameLostRun, that_is_longer_ends_with_the_timeout_where_the_wire_falls_silent) {
    const Link link =
        Link({.frame_lost_run = 500ms}).moving(70ms).same(105ms, frame_lost(sticks()));
    EXPECT_EQ(link.cause(198ms - 1ns), LinkCause::good);  // the last at 98 ms
    EXPECT_EQ(link.cause(198ms), LinkCause::wire_silent);
}

TEST(FrameLostRun, does_not_bring_a_lost_link_back) {
    const Link link =
        Link({.frame_lost_run = 5s}).moving(70ms).silence(400ms).same(500ms, frame_lost(sticks()));
    EXPECT_FALSE(link.supervisor().alive(at(500ms)));
}

TEST(FrameLostRatio, of_more_than_nine_in_ten_is_a_loss) {
    const auto lossy = [](std::int64_t good_each) {
        return Link().moving(70ms).frames(3s, [=](std::int64_t n) {
            return n % good_each == 0 ? sticks(1200 + n % 100) : frame_lost(sticks());
        });
    };
    EXPECT_EQ(lossy(10).cause(3s), LinkCause::good);
    EXPECT_EQ(lossy(12).cause(3s), LinkCause::radio_lost);
    EXPECT_EQ(lossy(12).state(3s).sign, RadioLossSign::frame_lost_ratio);
}

TEST(FrameLostRatio, of_one_turns_it_off) {
    const Link link = Link({.frame_lost_ratio = 1}).frames(3s, [](std::int64_t n) {
        return n % 13 == 0 ? sticks(1200 + n % 100) : frame_lost(sticks());
    });
    EXPECT_EQ(link.cause(3s), LinkCause::good);
}

TEST(FrameLostRatio, lets_the_link_come_back_at_half_of_every_limit) {
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

TEST(FrameLostRatio, that_was_too_high_must_fall_well_below_before_the_link_is_good_again) {
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

TEST(FrameLostRatio, is_over_soon_after_the_frames_are_good_again) {
    const auto lossy_until_a_second = [](std::int64_t n) {
        return n % 12 == 0 ? sticks(1200 + n % 100) : frame_lost(sticks());
    };
    const Link link = Link().frames(2s, lossy_until_a_second).moving(2100ms);
    EXPECT_EQ(link.cause(2100ms), LinkCause::good);
}

TEST(ValueRules, say_loss_below_above_or_between) {
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

TEST(ValueRules, say_nothing_of_a_channel_that_is_absent) {
    ChannelFrame frame = sticks();
    frame.remove(2);
    const ValueRule below{.channel = 2, .below = us(950)};
    EXPECT_EQ(Link({.failsafe_when = {below}}).same(70ms, frame).cause(70ms), LinkCause::good);
}

TEST(ValueRules, all_zero_needs_every_channel_at_the_zero_of_the_wire) {
    const SupervisionSettings settings{
        .failsafe_when = {{.all_zero = true}}, .raw_zero = kRawZero, .zero_guard = 0ms};
    ChannelFrame almost = zeros();
    almost.set(15, us(881));
    EXPECT_EQ(Link(settings).same(70ms, zeros()).cause(70ms), LinkCause::radio_lost);
    EXPECT_EQ(Link(settings).same(70ms, zeros()).state(70ms).sign, RadioLossSign::value_rule);
    EXPECT_EQ(Link(settings).same(70ms, almost).cause(70ms), LinkCause::good);
}

TEST(Frozen, no_change_of_any_bit_for_so_long_is_a_loss_since_the_last_change) {
    const Link link = Link({.frozen = 500ms}).moving(1s).same(2s, sticks(1000));
    EXPECT_EQ(link.cause(1501ms - 1ns), LinkCause::good);  // still since 1001 ms
    EXPECT_EQ(link.cause(1501ms), LinkCause::stale);
    EXPECT_EQ(link.state(1501ms).since, at(1001ms));
}

TEST(Frozen, a_single_eighth_of_a_microsecond_is_a_change) {
    const Link link = Link({.frozen = 500ms}).frames(3s, [](std::int64_t n) {
        ChannelFrame frame = sticks();
        frame.set(7, Pulse::from_eighths(12000 + n % 2));
        return frame;
    });
    EXPECT_EQ(link.cause(3s), LinkCause::good);
}

TEST(Frozen, a_flag_that_changes_is_no_change_of_the_values) {
    const Link link = Link({.frozen = 500ms}).frames(490ms, [](std::int64_t n) {
        return n % 2 == 0 ? sticks() : frame_lost(sticks());
    });
    EXPECT_EQ(link.cause(499ms), LinkCause::good);
    EXPECT_EQ(link.cause(500ms), LinkCause::stale);
}

TEST(Frozen, an_implausible_frame_between_frames_that_do_not_change_is_no_change) {
    const SupervisionSettings settings{.frozen = 500ms, .plausible = PulseRange{us(900), us(2100)}};
    const Link link = Link(settings)
                          .same(350ms, sticks(1200))
                          .same(357ms, sticks(2101))  // damaged, although its sum is right
                          .same(600ms, sticks(1200));
    EXPECT_EQ(link.cause(500ms - 1ns), LinkCause::good);
    EXPECT_EQ(link.cause(600ms), LinkCause::stale);
    EXPECT_EQ(link.state(600ms).since, at(0ms));
}

TEST(Frozen, values_that_come_back_after_implausible_ones_for_the_timeout_are_new) {
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

TEST(Frozen, values_that_come_back_after_an_implausible_frame_and_silence_are_not_new) {
    const SupervisionSettings settings{.frozen = 500ms, .plausible = PulseRange{us(900), us(2100)}};
    const Link link = Link(settings)
                          .same(350ms, sticks(1200))
                          .same(357ms, sticks(2101))
                          .silence(490ms)
                          .same(600ms, sticks(1200));
    EXPECT_EQ(link.cause(600ms), LinkCause::stale);
}

TEST(Frozen, is_off_where_nobody_asked_for_it) {
    EXPECT_EQ(Link().same(60s, sticks()).cause(60s), LinkCause::good);
}

TEST(Frozen, a_link_that_moves_again_begins_its_run_anew) {
    const Link link = Link({.frozen = 500ms}).moving(1s).same(2s, sticks(1000)).moving(2100ms);
    EXPECT_EQ(link.cause(2100ms), LinkCause::good);
    EXPECT_FALSE(link.supervisor().first_run());
    EXPECT_EQ(link.state(2100ms).since, at(2002ms));
}

TEST(Plausible, a_frame_outside_of_the_range_keeps_the_values_of_the_one_before_and_marks_them) {
    const SupervisionSettings settings{.plausible = PulseRange{us(900), us(2100)}};
    const Link link = Link(settings).same(70ms, sticks(1200)).same(77ms, sticks(2101));
    EXPECT_EQ(link.cause(77ms), LinkCause::good);
    EXPECT_EQ(link.supervisor().control().channel(2), us(1200));
    EXPECT_TRUE(link.supervisor().control().frame_lost);
}

TEST(Plausible, nothing_but_frames_outside_of_the_range_is_a_loss_after_the_timeout) {
    const SupervisionSettings settings{.plausible = PulseRange{us(900), us(2100)}};
    const Link link = Link(settings).same(70ms, sticks(1200)).same(400ms, sticks(899));
    EXPECT_EQ(link.cause(163ms - 1ns), LinkCause::good);
    EXPECT_EQ(link.cause(400ms), LinkCause::implausible);
    EXPECT_EQ(link.state(400ms).since, at(70ms));
}

TEST(ZeroGuard, a_receiver_whose_flag_clears_400_ms_before_its_channels_are_back_is_not_believed) {
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

TEST(ZeroGuard, ends_so_that_a_channel_that_rests_at_zero_costs_no_more_than_its_time) {
    ChannelFrame resting = sticks();
    resting.set(9, kRawZero);
    const SupervisionSettings settings{.raw_zero = kRawZero};
    EXPECT_EQ(Link(settings).same(994ms, resting).cause(994ms), LinkCause::implausible);
    const Link link = Link(settings).same(3s, resting);
    EXPECT_EQ(link.cause(3s), LinkCause::good);
    EXPECT_EQ(link.state(3s).since, at(1001ms));
}

TEST(ZeroGuard, does_not_mind_a_zero_in_the_midst_of_good_frames) {
    ChannelFrame low = sticks();
    low.set(2, kRawZero);
    const Link link = Link({.raw_zero = kRawZero}).moving(2s).same(3s, low);
    EXPECT_EQ(link.cause(3s), LinkCause::good);
    EXPECT_EQ(link.supervisor().control().channel(2), kRawZero);
}

TEST(ZeroGuard, begins_anew_after_each_loss) {
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

TEST(ZeroGuard, of_nothing_is_off) {
    ChannelFrame half = sticks();
    half.set(2, kRawZero);
    const Link link = Link({.raw_zero = kRawZero, .zero_guard = 0ms}).same(70ms, half);
    EXPECT_EQ(link.cause(70ms), LinkCause::good);
}

/// With time stamps of a CAN socket: the first frame came when the link had been lost for 100 ms.
TEST(LinkAbsence, in_which_frames_came_after_a_loss_is_a_loss_since_that) {
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
TEST(LinkAbsence, in_which_frames_went_on_is_a_loss_all_the_same) {
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

TEST(ChannelsMissing, is_the_cause_where_frames_have_none_at_all_however_long_they_come) {
    ChannelFrame none = sticks();
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        none.remove(channel);
    }
    const Link link = Link().same(5s, none);
    EXPECT_EQ(link.cause(5s), LinkCause::channels_missing);
    EXPECT_FALSE(link.supervisor().ever_good());
}

TEST(ChannelsMissing, is_the_cause_since_a_channel_vanished_until_it_was_away_on_purpose) {
    Link link({.fewer_channels_after = 500ms});
    link.moving(70ms).same(560ms, without(4));
    EXPECT_EQ(link.cause(560ms), LinkCause::channels_missing);
    EXPECT_EQ(link.state(560ms).since, at(70ms));
    link.same(700ms, without(4));
    EXPECT_EQ(link.cause(700ms), LinkCause::good);
}

TEST(ChannelsMissing, counts_anew_where_another_channel_is_away_than_before) {
    Link link({.fewer_channels_after = 500ms});
    link.moving(70ms).same(420ms, without(4)).same(840ms, without(5));
    EXPECT_EQ(link.cause(840ms), LinkCause::channels_missing);
}

}  // namespace
}  // namespace tribus::test::link::link_supervisor_test
