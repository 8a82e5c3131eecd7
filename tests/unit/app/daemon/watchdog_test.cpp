#include "app/daemon/watchdog.h"

#include <chrono>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::test::watchdog_test {
namespace {

using namespace std::chrono_literals;

constexpr Duration kLook = 200ms;

/// A data thread with outputs of 10 ms, checked five times a second. The watchdog fires after 4 s,
/// so the program must notify it every 2 s.
class WatchdogTest : public testing::Test {
  protected:
    explicit WatchdogTest() { outputs_.assign(2, {.due = now_, .period = 10ms, .overruns = 0}); }

    /// Lets time pass. Returns the number of notifications.
    int go_on(Duration time, bool publishes = true, std::uint64_t missed_each_look = 0) {
        int words = 0;
        for (const Instant end = now_ + time; now_ < end;) {
            now_ += kLook;
            if (publishes) {
                published_ = now_ - 50ms;
                outputs_[0].due = published_ + 3ms;
                outputs_[1].due = published_ + 3ms;
                outputs_[1].overruns += missed_each_look;
            }
            words += watchdog_.look(now_, published_, outputs_, standing_) ? 1 : 0;
        }
        return words;
    }

    Instant now_{1000s};
    Instant published_{};
    std::vector<OutputProgress> outputs_;
    Standing standing_;
    Watchdog watchdog_{4s};
};

TEST_F(WatchdogTest, IsFedAtTheFirstLookAndEachHalfOfItsTime) {
    EXPECT_EQ(go_on(200ms), 1);
    EXPECT_EQ(go_on(1800ms), 0);
    EXPECT_EQ(go_on(200ms), 1);
    EXPECT_EQ(go_on(20s), 10);
}

TEST_F(WatchdogTest, IsNotFedBeforeTheDataThreadHasToldAnything) {
    EXPECT_EQ(go_on(10s, false), 0);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::data_thread_stands);
}

TEST_F(WatchdogTest, IsNotFedOnceTheDataThreadStands) {
    go_on(10s);
    go_on(1s, false);
    EXPECT_EQ(go_on(60s, false), 0);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::data_thread_stands);
}

TEST_F(WatchdogTest, ADataThreadThatHasJustBegunDoesNotStand) {
    EXPECT_FALSE(watchdog_.look(now_, Instant{}, outputs_));
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
    EXPECT_EQ(go_on(200ms), 1);
}

/// After SIGCONT this thread may run before the data thread.
TEST_F(WatchdogTest, AStopOfTheWholeProgramIsNoStopOfTheDataThread) {
    go_on(10s);
    now_ += 60s;
    EXPECT_FALSE(watchdog_.look(now_, published_, outputs_));
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
    EXPECT_EQ(go_on(200ms), 1);
}

/// The data thread counts the turns that its outputs missed meanwhile.
TEST_F(WatchdogTest, AStopOfTheWholeProgramMakesNoOutputLate) {
    go_on(10s);
    now_ += 1300ms;
    go_on(200ms, true, 130);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
    go_on(200ms);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
}

TEST_F(WatchdogTest, ManyStopsOneBehindTheOtherMakeNoOutputLate) {
    go_on(10s);
    for (int stop = 0; stop < 5; ++stop) {
        now_ += 1300ms;
        go_on(200ms, true, 130);
        EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
    }
}

TEST_F(WatchdogTest, OneStandsThatGivesNoSignAfterAStopOfTheWholeProgram) {
    go_on(10s);
    now_ += 60s;
    EXPECT_EQ(go_on(1200ms, false), 0);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::data_thread_stands);
}

TEST_F(WatchdogTest, APauseShorterThanASecondDoesNotMatter) {
    go_on(10s);
    go_on(800ms, false);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
}

TEST_F(WatchdogTest, IsFedAgainAtOnceWhenAThreadThatStoodGoesOn) {
    go_on(10s);
    go_on(3s, false);
    EXPECT_EQ(go_on(200ms), 1);
}

TEST_F(WatchdogTest, IsNotFedOnceAnotherPartHasStoodForMoreThanASecond) {
    for (const auto part :
         {Standing::Part::port_unheard, Standing::Part::link_thread, Standing::Part::gpio_thread}) {
        go_on(10s);
        standing_ = {.part = part, .port = 1};
        go_on(1200ms);
        EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
        EXPECT_EQ(go_on(60s), 0);
        EXPECT_EQ(watchdog_.punctuality(), Punctuality::part_stands);
        EXPECT_EQ(watchdog_.standing(), standing_);
        standing_ = {};
        EXPECT_EQ(go_on(200ms), 1) << "it goes on";
    }
}

TEST_F(WatchdogTest, IsFedWhileAnOutputMissesFewerThanHalfOfItsTurns) {
    go_on(200ms);
    EXPECT_EQ(go_on(20s, true, 9), 10);
}

TEST_F(WatchdogTest, IsNotFedWhileAnOutputMissesMoreThanHalfOfItsTurns) {
    go_on(200ms);
    EXPECT_EQ(go_on(20s, true, 11), 0);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::output_late);
    EXPECT_EQ(watchdog_.late_output(), 1U);
}

TEST_F(WatchdogTest, IsNotFedWhileTheTurnOfAnOutputIsForgotten) {
    go_on(2s);
    now_ += 5s;
    published_ = now_;
    outputs_[0].due = published_ + 3ms;
    outputs_[1].due = published_ - 11ms;
    EXPECT_FALSE(watchdog_.look(now_, published_, outputs_));
    EXPECT_EQ(watchdog_.late_output(), 1U);
}

TEST_F(WatchdogTest, AnOutputThatWaitsLongForItsNextTurnIsOnTime) {
    outputs_[1].period = 10s;
    go_on(200ms);
    outputs_[1].due = now_ + 10s;
    EXPECT_EQ(go_on(2s), 1);
}

TEST_F(WatchdogTest, CountsOfAFreshDataThreadAreNotComparedWithThoseOfTheOldOne) {
    go_on(10s, true, 9);
    watchdog_.restart();
    outputs_[1].overruns = 0;
    EXPECT_EQ(go_on(20s, true, 9), 10);
    watchdog_.restart();
    outputs_.resize(3, {.due = now_ + 100s, .period = 10ms, .overruns = 7});
    EXPECT_EQ(go_on(20s), 10);
}

TEST_F(WatchdogTest, IsNotFedWithFiguresThatAreOlderThanASecond) {
    EXPECT_TRUE(Watchdog(4s).look(now_, now_ - 1s, outputs_));
    EXPECT_FALSE(Watchdog(4s).look(now_, now_ - 1s - 1ns, outputs_));
}

TEST_F(WatchdogTest, ADataThreadStandsIfItHasGivenNoSignForMoreThanASecond) {
    published_ = now_;
    for (int look = 0; look <= 5; ++look, now_ += 200ms) {
        watchdog_.look(now_, published_, outputs_);
        EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time) << look;
    }
    watchdog_.look(now_, published_, outputs_);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::data_thread_stands);
}

TEST_F(WatchdogTest, APartStandsIfItHasStoodForMoreThanASecond) {
    go_on(2s);
    standing_ = {.part = Standing::Part::link_thread, .port = 1};
    go_on(1200ms);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
    go_on(200ms);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::part_stands);
}

TEST_F(WatchdogTest, AnotherPartThatStandsHasASecondOfItsOwn) {
    go_on(2s);
    for (std::size_t port = 0; port < 10; ++port) {
        standing_ = {.part = Standing::Part::link_thread, .port = port};
        go_on(800ms);
        EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
    }
}

TEST_F(WatchdogTest, AnOutputThatMissesExactlyHalfOfItsTurnsIsOnTime) {
    go_on(200ms);
    EXPECT_EQ(go_on(20s, true, 10), 10);
}

TEST_F(WatchdogTest, AnOutputIsLateOnceItHasMissedHalfOfItsTurnsTwiceInARow) {
    go_on(2s);
    go_on(200ms, true, 11);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
    go_on(200ms);
    go_on(200ms, true, 11);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time) << "not in a row";
    go_on(200ms, true, 11);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::output_late);
    go_on(200ms);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
}

TEST_F(WatchdogTest, AnOutputOfALongPeriodIsLateByOneTurn) {
    go_on(2s);
    outputs_[1].period = 150ms;
    go_on(200ms, true, 1);
    go_on(200ms, true, 1);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::output_late);
}

TEST_F(WatchdogTest, TheFirstOutputThatIsLateIsNamed) {
    published_ = now_;
    outputs_[0].due = published_ - 11ms;
    outputs_[1].due = published_ - 11ms;
    watchdog_.look(now_, published_, outputs_);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::output_late);
    EXPECT_EQ(watchdog_.late_output(), 0U);
}

TEST_F(WatchdogTest, AnOutputIsLateIfItsTurnIsMoreThanAPeriodAgo) {
    published_ = now_;
    outputs_[0].due = published_ + 3ms;
    outputs_[1].due = published_ - 10ms;
    watchdog_.look(now_, published_, outputs_);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
    outputs_[1].due = published_ - 10ms - 1ns;
    watchdog_.look(now_ + 1ms, published_ + 1ns, outputs_);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::output_late);
}

TEST_F(WatchdogTest, AnOutputThatWasLateIsSoUntilTheDataThreadPublishesAgain) {
    published_ = now_;
    outputs_[0].due = published_ - 11ms;
    watchdog_.look(now_, published_, outputs_);
    outputs_[0].due = published_ + 3ms;
    EXPECT_FALSE(watchdog_.look(now_ + 200ms, published_, outputs_));
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::output_late);
    outputs_[0].due = outputs_[1].due = published_ + 403ms;
    EXPECT_TRUE(watchdog_.look(now_ + 400ms, published_ + 400ms, outputs_));
}

TEST_F(WatchdogTest, HalfASecondBetweenTwoLooksIsNoStop) {
    const auto look_twice_each = [&](Duration pause) {
        for (int look = 0; look < 6; ++look) {
            now_ += pause;
            published_ = now_ - 50ms;
            outputs_[0].due = outputs_[1].due = published_ + 3ms;
            outputs_[1].overruns += 40;
            watchdog_.look(now_, published_, outputs_);
        }
        return watchdog_.punctuality();
    };
    EXPECT_EQ(look_twice_each(500ms), Punctuality::output_late);
    watchdog_.restart();
    EXPECT_EQ(look_twice_each(500ms + 1ns), Punctuality::on_time);
}

/// After a stop the first figures that count are those published when the program goes on.
TEST_F(WatchdogTest, AnOutputThatIsLateAfterAStopIsFoundWithTheSecondPublication) {
    go_on(2s);
    now_ += 60s;
    const auto look = [&](std::uint64_t missed) {
        published_ = now_;
        outputs_[0].due = outputs_[1].due = published_ + 3ms;
        outputs_[1].overruns += missed;
        watchdog_.look(now_, published_, outputs_);
        now_ += 200ms;
        return watchdog_.punctuality();
    };
    EXPECT_EQ(look(6000), Punctuality::on_time);
    EXPECT_EQ(look(11), Punctuality::on_time);
    EXPECT_EQ(look(11), Punctuality::output_late);
}

TEST_F(WatchdogTest, AfterARestartALongPauseIsNoStop) {
    go_on(2s);
    now_ += 60s;
    watchdog_.restart();
    go_on(200ms);
    go_on(200ms, true, 11);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
    go_on(200ms, true, 11);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::output_late);
}

TEST_F(WatchdogTest, AFreshDataThreadHasASecondForItsFirstSign) {
    go_on(10s);
    go_on(3s, false);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::data_thread_stands);
    watchdog_.restart();
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
    go_on(1200ms, false);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
    go_on(200ms, false);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::data_thread_stands);
}

TEST_F(WatchdogTest, AfterARestartAPartThatStandsHasASecondAgain) {
    go_on(10s);
    standing_ = {.part = Standing::Part::gpio_thread};
    go_on(3s);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::part_stands);
    watchdog_.restart();
    EXPECT_EQ(watchdog_.standing(), Standing{});
    go_on(1200ms);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time);
    go_on(200ms);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::part_stands);
}

TEST_F(WatchdogTest, AFreshDataThreadIsJudgedByItsFirstSign) {
    published_ = now_;
    outputs_[0].due = outputs_[1].due = published_ + 3ms;
    watchdog_.look(now_, published_, outputs_);
    watchdog_.restart();
    outputs_[1].due = published_ - 11ms;
    watchdog_.look(now_, published_, outputs_);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::output_late);
}

TEST_F(WatchdogTest, CountsOfMoreOutputsThanBeforeAreNotCompared) {
    go_on(2s);
    outputs_.resize(3, {.due = now_ + 100s, .period = 10ms, .overruns = 1000});
    go_on(200ms);
    outputs_[2].overruns += 1000;
    go_on(200ms);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::on_time) << "missed once";
    outputs_[2].overruns += 1000;
    go_on(200ms);
    EXPECT_EQ(watchdog_.punctuality(), Punctuality::output_late);
    EXPECT_EQ(watchdog_.late_output(), 2U);
}

TEST_F(WatchdogTest, OneWhoFeedsAllInputsHasNoOutputsToBeLate) {
    outputs_.clear();
    published_ = now_;
    EXPECT_TRUE(watchdog_.look(now_, published_, outputs_));
}

}  // namespace
}  // namespace tribus::test::watchdog_test
