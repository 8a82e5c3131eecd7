#include "core/arrival_clock.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/unit/core/arrivals.h"

namespace tribus::test::arrival_clock_test {
namespace {

using namespace test::arrivals;

using namespace std::chrono_literals;

TEST(ArrivalClock, KnowsNoIntervalBeforeTheSecondFrame) {
    ArrivalClock arrivals;
    EXPECT_FALSE(arrivals.ever());
    arrivals.arrived(at(5ms));
    EXPECT_TRUE(arrivals.ever());
    EXPECT_EQ(arrivals.interval(), 0ms);
}

TEST(ArrivalClock, OneLateFrameHardlyChangesTheInterval) {
    ArrivalClock arrivals = arrivals_each(7700us, at(0ms), 100);
    arrivals.arrived(arrivals.latest() + 9300us);
    EXPECT_EQ(arrivals.interval(), 7'700'904ns);
}

TEST(ArrivalClock, TheIntervalOfFramesThatJitterIsExactToAThousandth) {
    std::minstd_rand random(4);
    ArrivalClock arrivals;
    for (int i = 0; i < 1000; ++i) {
        arrivals.arrived(at(i * 7700us + std::chrono::microseconds(random() % 400)));
        if (i > 100) {
            ASSERT_NEAR(static_cast<double>(arrivals.interval().count()), 7'700e3, 8e3) << i;
        }
    }
}

TEST(ArrivalClock, TheLineGoesThroughTheMiddleOfArrivalsThatJitter) {
    ArrivalClock arrivals;
    for (int i = 0; i < 1000; ++i) {
        arrivals.arrived(at(i * 7700us + (i % 2 == 0 ? 0us : 200us)));
    }
    EXPECT_NEAR(static_cast<double>((arrivals.fitted() - at(999 * 7700us)).count()), 100e3, 20e3);
    EXPECT_NEAR(static_cast<double>(arrivals.lateness().count()), 100e3, 20e3);
}

TEST(ArrivalClock, TheLineStartsAgainWithTheSecondFrameWithTheSameError) {
    ArrivalClock arrivals = arrivals_each(7700us, at(0ms), 100);
    const Instant anew = arrivals.latest() + 3 * 7700us + 3ms;
    arrivals.arrived(anew);
    EXPECT_NE(arrivals.fitted(), arrivals.latest());
    arrivals.arrived(anew + 7700us);
    EXPECT_EQ(arrivals.fitted(), arrivals.latest());
}

TEST(ArrivalClock, FramesWithDifferentErrorsDoNotRestartTheLine) {
    ArrivalClock arrivals = arrivals_each(7700us, at(0ms), 100);
    const Instant latest = arrivals.latest();
    arrivals.arrived(latest + 7700us + 2500us);
    arrivals.arrived(latest + 2 * 7700us - 1500us);
    arrivals.arrived(latest + 3 * 7700us + 1200us);
    EXPECT_NEAR(static_cast<double>((arrivals.fitted() - latest - 3 * 7700us).count()), 0, 200e3);
}

TEST(ArrivalClock, TwoFramesOfOneReadAreNoInterval) {
    ArrivalClock arrivals;
    arrivals.arrived(at(5ms));
    arrivals.arrived(at(5ms));
    EXPECT_EQ(arrivals.interval(), 0ms);
    EXPECT_EQ(arrivals.fitted(), at(5ms));
    arrivals.arrived(at(12ms));
    EXPECT_EQ(arrivals.interval(), 7ms);
}

TEST(ArrivalClock, OneMissingFrameDoesNotChangeTheInterval) {
    ArrivalClock arrivals = arrivals_each(7700us, at(0ms), 10);
    arrivals.arrived(arrivals.latest() + 2 * 7700us);
    EXPECT_EQ(arrivals.interval(), 7700us);
}

TEST(ArrivalClock, LearnsANewPeriodFromAFewFrames) {
    ArrivalClock arrivals = arrivals_each(14ms, at(0ms), 10);
    for (int i = 0; i < 4; ++i) {
        arrivals.arrived(arrivals.latest() + 4ms);
    }
    EXPECT_EQ(arrivals.interval(), 4ms);
}

TEST(ArrivalClock, KnowsAnySenderAfterFortyFramesWhateverCameBefore) {
    for (Duration before = 1ms; before < 30ms; before += 370us) {
        for (Duration after = 4ms; after < 30ms; after += 410us) {
            ArrivalClock arrivals = arrivals_each(before, at(0ms), 300);
            const Instant anew = arrivals.latest() + 11ms;
            for (int i = 0; i < 40; ++i) {
                arrivals.arrived(anew + i * after);
            }
            ASSERT_NEAR(static_cast<double>(arrivals.interval() / 1us),
                        static_cast<double>(after / 1us), static_cast<double>(after / 100us))
                << "before: " << before / 1us << " us";
        }
    }
}

TEST(ArrivalClock, OneOddFirstIntervalIsNotTakenForAPeriodWithFramesMissing) {
    // 7 ms are five quarters of 5.6 ms: every fifth would be missing.
    ArrivalClock arrivals = arrivals_each(4ms, at(0ms), 2);
    const Instant regular = arrivals.latest() + 5ms;
    for (int i = 0; i < 40; ++i) {
        arrivals.arrived(regular + i * 7ms);
    }
    EXPECT_NEAR(static_cast<double>(arrivals.interval() / 1us), 7000, 10);
}

TEST(ArrivalClock, LatenessIsForgottenWhereFramesComeOnTheBeatAgain) {
    ArrivalClock arrivals;
    for (int frame = 0; frame < 400; ++frame) {
        arrivals.arrived(at(frame * 7ms + (frame % 4 == 0 ? 800us : 0us)));
    }
    EXPECT_GT(arrivals.lateness(), 200us);
    for (int frame = 400; frame < 1600; ++frame) {
        arrivals.arrived(at(frame * 7ms));
    }
    EXPECT_LT(arrivals.lateness(), 20us);
}

}  // namespace
}  // namespace tribus::test::arrival_clock_test
