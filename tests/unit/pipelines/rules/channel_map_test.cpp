#include "pipelines/rules/channel_map.h"

#include <gtest/gtest.h>

#include <vector>

namespace tribus::channel_map_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kNow = Instant(1s);

Pulse us(std::int64_t microseconds) {
    return Pulse::from_microseconds(microseconds);
}

/// Channel n (from 1) is 1000 + 10 n.
ChannelFrame ladder() {
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        frame.set(channel, us(1010 + 10 * static_cast<std::int64_t>(channel)));
    }
    return frame;
}

ChannelFrame with_first(Pulse pulse) {
    ChannelFrame frame = ladder();
    frame.set(0, pulse);
    return frame;
}

std::int32_t first_us(ChannelMap& map, Pulse input, Instant now = kNow) {
    return map.apply(with_first(input), now).channel_or(0, Pulse{}).whole_microseconds();
}

ChannelMap map_of(ChannelRule rule) {
    return ChannelMap(std::vector{std::move(rule)});
}

ChannelRule first_from_first() {
    return {.output = 0, .source = FromChannel{0}};
}

TEST(ChannelMap, WithoutRulesAFramePassesUnchanged) {
    ChannelMap map({});
    EXPECT_TRUE(map.apply(ladder(), kNow).same_content(ladder()));
}

TEST(ChannelMap, ReverseTrimAndLimitsAreTheSameForEveryPulseWithAndWithoutASlew) {
    for (const bool reverse : {false, true}) {
        for (const int trim_us : {-4000, -25, 0, 25, 4000}) {
            ChannelRule rule = first_from_first();
            rule.reverse = reverse;
            rule.trim = us(trim_us);
            rule.min = us(-3500);
            rule.max = us(2012);
            ChannelMap straight = map_of(rule);
            rule.slew_us_per_second = 1e12;  // the same as no limit
            ChannelMap slewed = map_of(rule);
            for (std::int32_t eighths = INT16_MIN; eighths <= INT16_MAX; ++eighths) {
                const ChannelFrame frame = with_first(Pulse::from_eighths(eighths));
                const Instant at = kNow + std::chrono::milliseconds(eighths - INT16_MIN);
                ASSERT_EQ(straight.apply(frame, at).channel(0), slewed.apply(frame, at).channel(0))
                    << eighths << " reverse " << reverse << " trim " << trim_us;
            }
        }
    }
}

TEST(ChannelMap, ChannelsCanBeSwappedSinceAllReadTheInput) {
    ChannelMap map(std::vector<ChannelRule>{{.output = 0, .source = FromChannel{1}},
                                            {.output = 1, .source = FromChannel{0}}});
    const ChannelFrame out = map.apply(ladder(), kNow);
    EXPECT_EQ(out.channel(0), us(1020));
    EXPECT_EQ(out.channel(1), us(1010));
    EXPECT_EQ(out.channel(2), us(1030));
}

TEST(ChannelMap, AnAbsentSourceMakesAnAbsentChannel) {
    ChannelFrame input = ladder();
    input.remove(4);
    ChannelMap map(
        std::vector<ChannelRule>{{.output = 0, .source = FromChannel{4}, .reverse = true},
                                 {.output = 1, .source = Mix{{{3, 1.0}, {4, 1.0}}}},
                                 {.output = 2, .source = Switch{.channel = 4, .above = us(1700)}}});
    const ChannelFrame out = map.apply(input, kNow);
    EXPECT_FALSE(out.has(0));
    EXPECT_FALSE(out.has(1));
    EXPECT_FALSE(out.has(2));
}

/// A receiver may send other channels in each frame: nothing of the frame before may count.
TEST(ChannelMap, AChannelIsAbsentInEachFrameWhoseOwnSourceIsAbsent) {
    for (const std::size_t source : {std::size_t{3}, std::size_t{5}}) {
        ChannelMap map = map_of({.output = 3, .source = FromChannel{source}, .max = us(2100)});
        for (const std::uint32_t absent : {0x3C000U, 0x00008U, 0x00020U, 0x00001U, 0U, 0x3C000U}) {
            ChannelFrame input = ladder();
            input.remove_all(absent);
            ChannelFrame expected = input;
            expected.set(3, input.channel(source));
            EXPECT_TRUE(map.apply(input, kNow).same_channels(expected))
                << "from " << source << ", absent " << std::hex << absent;
        }
    }
}

TEST(ChannelMap, AChannelThatTheReceiverLacksIsThereWhereARuleFillsIt) {
    ChannelFrame input = ladder();
    input.remove(14);
    input.remove(15);
    ChannelMap map = map_of({.output = 14, .source = FromChannel{0}});
    const ChannelFrame out = map.apply(input, kNow);
    EXPECT_EQ(out.channel(14), us(1010));
    EXPECT_FALSE(out.has(15));
}

TEST(ChannelMap, FlagsPass) {
    ChannelFrame input = ladder();
    input.frame_lost = true;
    ChannelMap map({});
    EXPECT_TRUE(map.apply(input, kNow).frame_lost);
}

TEST(ChannelMap, ReverseMirrorsAt1500Exactly) {
    ChannelMap map = map_of({.output = 0, .source = FromChannel{0}, .reverse = true});
    for (int eighths = 880 * 8; eighths <= 2160 * 8; ++eighths) {
        const ChannelFrame out = map.apply(with_first(Pulse::from_eighths(eighths)), kNow);
        ASSERT_EQ(out.channel_or(0, Pulse{}).eighths(), 24000 - eighths);
    }
}

TEST(ChannelMap, TrimAdds) {
    ChannelRule rule = first_from_first();
    rule.trim = us(12);
    ChannelMap map = map_of(rule);
    EXPECT_EQ(first_us(map, us(1500)), 1512);
}

TEST(ChannelMap, ReverseComesBeforeTrim) {
    ChannelRule rule = first_from_first();
    rule.reverse = true;
    rule.trim = us(12);
    ChannelMap map = map_of(rule);
    EXPECT_EQ(first_us(map, us(1400)), 1612);
}

TEST(ChannelMap, MinAndMaxComeLast) {
    ChannelRule rule = first_from_first();
    rule.trim = us(200);
    rule.min = us(1100);
    rule.max = us(1900);
    ChannelMap map = map_of(rule);
    EXPECT_EQ(first_us(map, us(800)), 1100);
    EXPECT_EQ(first_us(map, us(1900)), 1900);
    EXPECT_EQ(first_us(map, us(1500)), 1700);
}

TEST(ChannelMap, DeadbandReadsAsCentreAndKeepsFullTravelWithoutAStep) {
    ChannelRule rule = first_from_first();
    rule.deadband = us(50);
    ChannelMap map = map_of(rule);
    for (const int still : {1450, 1475, 1500, 1550}) {
        EXPECT_EQ(first_us(map, us(still)), 1500);
    }
    EXPECT_EQ(first_us(map, us(1551)), 1501);
    EXPECT_EQ(first_us(map, us(1000)), 1000);
    EXPECT_EQ(first_us(map, us(2000)), 2000);
    std::int32_t before = 0;
    for (int input = 900; input <= 2100; ++input) {
        const std::int32_t output = first_us(map, us(input));
        ASSERT_GE(output, before);
        ASSERT_LE(output - before, before == 0 ? 2000 : 2);
        before = output;
    }
}

TEST(ChannelMap, ExpoSoftensTheMiddleAndKeepsCentreAndEnds) {
    ChannelRule rule = first_from_first();
    rule.expo = 0.3;
    ChannelMap map = map_of(rule);
    EXPECT_EQ(first_us(map, us(1500)), 1500);
    EXPECT_EQ(first_us(map, us(1000)), 1000);
    EXPECT_EQ(first_us(map, us(2000)), 2000);
    // Half travel: 0.7 * 0.5 + 0.3 * 0.125 = 0.3875 of 500 us.
    EXPECT_EQ(first_us(map, us(1750)), 1694);
    EXPECT_EQ(first_us(map, us(2100)), 2100);
}

TEST(ChannelMap, MixAddsWeightedDeviations) {
    ChannelMap map = map_of({.output = 0, .source = Mix{{{1, 0.5}, {2, -0.5}}}});
    ChannelFrame input = ladder();
    input.set(1, us(1900));
    input.set(2, us(1300));
    // 1500 + 0.5 * 400 - 0.5 * (-200)
    EXPECT_EQ(map.apply(input, kNow).channel(0), us(1800));
}

/// 1500 + 10 * 500 us is 6500 us, more than a Pulse can be.
TEST(ChannelMap, AMixBeyondTheRangeOfAPulseIsLimitedAfterAllStepsAndNotBefore) {
    ChannelRule rule = {.output = 0, .source = Mix{{{0, 10.0}}}};
    rule.trim = us(-500);
    ChannelMap trimmed = map_of(rule);
    EXPECT_EQ(trimmed.apply(with_first(us(2000)), kNow).channel(0), Pulse::from_eighths(INT16_MAX))
        << "6000 us, not 4095.875 - 500";
    EXPECT_EQ(trimmed.apply(with_first(us(1700)), kNow).channel(0), us(3000));
    rule.trim = us(500);
    rule.reverse = true;
    ChannelMap reversed = map_of(rule);
    EXPECT_EQ(reversed.apply(with_first(us(2000)), kNow).channel(0), us(-3000));
    rule.min = us(900);
    ChannelMap limited = map_of(rule);
    EXPECT_EQ(limited.apply(with_first(us(2000)), kNow).channel(0), us(900));
}

TEST(ChannelMap, ASlewBehindSuchAMixIsNeverFurtherAwayThanTheRangeOfAPulse) {
    ChannelMap map = map_of({.output = 0, .source = Mix{{{0, 10.0}}}, .slew_us_per_second = 1000});
    map.apply(with_first(us(2000)), kNow);
    EXPECT_EQ(map.apply(with_first(us(1500)), kNow + 100ms).channel(0),
              Pulse::from_eighths(INT16_MAX - 800));
}

TEST(ChannelMap, FixedIgnoresTheInput) {
    ChannelMap map = map_of({.output = 15, .source = Fixed{us(1234)}});
    EXPECT_EQ(map.apply(ChannelFrame{}, kNow).channel(15), us(1234));
}

TEST(ChannelMap, ASwitchIsOnOnlyBeyondItsLimit) {
    ChannelMap above = map_of({.output = 0, .source = Switch{.channel = 0, .above = us(1700)}});
    EXPECT_EQ(first_us(above, us(1700)), 1000);
    EXPECT_EQ(first_us(above, us(1701)), 2000);
    ChannelMap below = map_of({.output = 0, .source = Switch{.channel = 0, .below = us(1300)}});
    EXPECT_EQ(first_us(below, us(1300)), 1000);
    EXPECT_EQ(first_us(below, us(1299)), 2000);
}

TEST(ChannelMap, ASwitchWithTwoLimitsIsOnOutsideOfThem) {
    ChannelMap map =
        map_of({.output = 0, .source = Switch{.channel = 0, .above = us(1700), .below = us(1300)}});
    EXPECT_EQ(first_us(map, us(1299)), 2000);
    EXPECT_EQ(first_us(map, us(1300)), 1000);
    EXPECT_EQ(first_us(map, us(1700)), 1000);
    EXPECT_EQ(first_us(map, us(1701)), 2000);
}

TEST(ChannelMap, SlewLimitsTheSpeedFromTheSecondValueOn) {
    ChannelRule rule = first_from_first();
    rule.slew_us_per_second = 2000;
    ChannelMap map = map_of(rule);
    EXPECT_EQ(first_us(map, us(1000), Instant(1s)), 1000);
    EXPECT_EQ(first_us(map, us(2000), Instant(1s + 10ms)), 1020);
    EXPECT_EQ(first_us(map, us(2000), Instant(1s + 110ms)), 1220);
    EXPECT_EQ(first_us(map, us(1000), Instant(1s + 120ms)), 1200);
    EXPECT_EQ(first_us(map, us(1000), Instant(3s)), 1000);
}

TEST(ChannelMap, SlewGoesOnFromPresets) {
    ChannelRule rule = first_from_first();
    rule.slew_us_per_second = 1000;
    ChannelMap map = map_of(rule);
    EXPECT_EQ(first_us(map, us(2000), Instant(1s)), 2000);
    map.restart_from(with_first(us(988)), Instant(2s));
    EXPECT_EQ(first_us(map, us(2000), Instant(2s + 12ms)), 1000);
}

TEST(ChannelMap, ASlewDoesNotBeginAnewWhereWhatWasSaidLacksItsChannel) {
    ChannelMap map = map_of({.source = FromChannel{0}, .slew_us_per_second = 1000});
    EXPECT_EQ(first_us(map, us(2000)), 2000);
    ChannelFrame said = ladder();
    said.remove(0);
    map.restart_from(said, kNow);
    EXPECT_EQ(first_us(map, us(2000), kNow + 10ms), 2000);
}

}  // namespace
}  // namespace tribus::channel_map_test
