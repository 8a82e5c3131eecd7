#include "pipelines/rules/line_wave.h"

#include <gtest/gtest.h>

namespace tribus::test::line_wave_test {
namespace {

using namespace std::chrono_literals;

Instant at(Duration since_start) {
    return Instant(since_start);
}

/// Returns how often a wave of 40 ms changes its level until `until`. `fresh` returns when the data
/// was last fresh.
template <class Fresh>
int turns(Instant until, Fresh fresh) {
    FreshWave wave(40ms, at(0ms));
    int count = 0;
    for (Instant now = wave.next(); now <= until; now = wave.next()) {
        count += wave.turn(fresh(now), now) ? 1 : 0;
    }
    return count;
}

/// Returns the latest time before `now` at which an output with a period of 10 ms, from 3 ms on,
/// wrote.
Instant written_before(Instant now) {
    return at((now.time_since_epoch() - 3ms) / 10ms * 10ms + 3ms);
}

TEST(FreshWave, TurnsEachHalfPeriodWhileDataIsFresh) {
    EXPECT_EQ(turns(at(1s), written_before), 50);
}

TEST(FreshWave, NeverTurnsWithoutData) {
    EXPECT_EQ(turns(at(1s), [](Instant) { return Instant{}; }), 0);
}

TEST(FreshWave, TurnsNoMoreThanOnceAfterTheLastFreshData) {
    const auto until_500 = [](Instant now) { return std::min(written_before(now), at(493ms)); };
    EXPECT_EQ(turns(at(500ms), until_500), 25);
    EXPECT_EQ(turns(at(10s), until_500), 25);
}

TEST(FreshWave, GoesOnWhenDataIsFreshAgain) {
    const auto with_gap = [](Instant now) {
        return now > at(500ms) && now < at(700ms) ? at(493ms) : written_before(now);
    };
    EXPECT_EQ(turns(at(1s), with_gap), 50 - 9);
}

TEST(FreshWave, TurnsOnceForDataOfOneInstant) {
    FreshWave wave(40ms, at(0ms));
    EXPECT_TRUE(wave.turn(at(19ms), at(20ms)));
    EXPECT_TRUE(wave.active());
    EXPECT_FALSE(wave.turn(at(19ms), at(39ms)));
    EXPECT_TRUE(wave.active());
}

TEST(FreshWave, MakesUpForNoTimeThatItSlept) {
    FreshWave wave(40ms, at(0ms));
    EXPECT_TRUE(wave.turn(at(99ms), at(101ms)));
    EXPECT_EQ(wave.next(), at(120ms));
    EXPECT_TRUE(wave.turn(at(119ms), at(120ms)));
    EXPECT_EQ(wave.next(), at(140ms));
}

/// A process that was stopped and continues: what it wrote before is old.
TEST(FreshWave, DoesNotTurnForDataThatGrewOldWhileItSlept) {
    FreshWave wave(40ms, at(0ms));
    EXPECT_FALSE(wave.turn(at(19ms), at(10s)));
    EXPECT_FALSE(wave.turn(at(9999ms) - 20ms, at(10s)));
    EXPECT_EQ(wave.next(), at(10s) + 20ms);
}

TEST(Blinking, IsOnAndOffTwiceASecond) {
    EXPECT_TRUE(blink_is_on(at(0ms)));
    EXPECT_TRUE(blink_is_on(at(249ms)));
    EXPECT_FALSE(blink_is_on(at(250ms)));
    EXPECT_FALSE(blink_is_on(at(499ms)));
    EXPECT_TRUE(blink_is_on(at(500ms)));
    EXPECT_EQ(next_blink(at(0ms)), at(250ms));
    EXPECT_EQ(next_blink(at(249ms)), at(250ms));
    EXPECT_EQ(next_blink(at(250ms)), at(500ms));
}

}  // namespace
}  // namespace tribus::test::line_wave_test
