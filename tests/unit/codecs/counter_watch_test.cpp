#include "transports/codecs/counter_watch.h"

#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include <gtest/gtest.h>

namespace tribus {
namespace {

using std::chrono::milliseconds;
using Verdict = CounterWatch::Verdict;
using Verdicts = std::vector<Verdict>;

constexpr Duration kPeriod = milliseconds(10);
constexpr Duration kSilence = milliseconds(250);

/// A watch of a counter from 0 to 15, of which up to two in a row may be lost, with its clock.
class Watched {
  public:
    Verdict take(std::uint64_t count, bool same_content = false, Duration after = kPeriod) {
        now_ += after;
        return watch_.take(count, same_content, now_);
    }
    Verdicts take_all(std::initializer_list<std::uint64_t> counts) {
        Verdicts verdicts;
        for (const std::uint64_t count : counts) {
            verdicts.push_back(take(count));
        }
        return verdicts;
    }
    void doubt() { watch_.doubt(); }

  private:
    CounterWatch watch_{{.values = 16, .most_step = 3, .silence = kSilence}};
    Instant now_{milliseconds(5000)};
};

TEST(CounterWatch, BelievesTheThirdInARow) {
    EXPECT_EQ(Watched().take_all({7, 8, 9, 10}),
              (Verdicts{Verdict::unconfirmed, Verdict::unconfirmed, Verdict::good, Verdict::good}));
}

TEST(CounterWatch, GoesOnFromTheHighestValueToZero) {
    Watched watched;
    watched.take_all({13, 14, 15});
    EXPECT_EQ(watched.take(0), Verdict::good);
}

TEST(CounterWatch, TheMostStepIsAnAdvanceAndOneMoreIsAJump) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(5), Verdict::good);
    EXPECT_EQ(watched.take(9), Verdict::jump);
}

TEST(CounterWatch, GoingBackByOneIsAJump) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(1), Verdict::jump);
}

TEST(CounterWatch, AfterAJumpProofIsDueFromThere) {
    Watched watched;
    watched.take_all({0, 1, 2, 9});
    EXPECT_EQ(watched.take_all({10, 11}), (Verdicts{Verdict::unconfirmed, Verdict::good}));
}

TEST(CounterWatch, TheSameContentAgainCostsNoProof) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(2, true), Verdict::repeated);
    EXPECT_EQ(watched.take(3), Verdict::good);
}

TEST(CounterWatch, AnotherContentUnderTheSameCounterCostsTheProof) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(2, false), Verdict::conflict);
    EXPECT_EQ(watched.take_all({3, 4}), (Verdicts{Verdict::unconfirmed, Verdict::good}));
}

TEST(CounterWatch, AValueThatTheCounterNeverHasIsAJumpAndNoReference) {
    Watched watched;
    watched.take_all({13, 14, 15});
    EXPECT_EQ(watched.take_all({16, 0, 1, 2}),
              (Verdicts{Verdict::jump, Verdict::unconfirmed, Verdict::unconfirmed, Verdict::good}));
}

TEST(CounterWatch, AsLongAsTheSilenceTheCounterStillSaysSomething) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(3, false, kSilence), Verdict::good);
}

TEST(CounterWatch, AfterMoreThanTheSilenceItStartsAnew) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(3, false, kSilence + Duration(1)), Verdict::unconfirmed);
    EXPECT_EQ(watched.take_all({4, 5}), (Verdicts{Verdict::unconfirmed, Verdict::good}));
}

TEST(CounterWatch, WhatIsRefusedEndsTheSilenceToo) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(2, true, kSilence), Verdict::repeated);
    EXPECT_EQ(watched.take(3, false, kSilence), Verdict::good);
}

TEST(CounterWatch, DoubtFromOutsideMakesAllProofDueButKeepsTheReference) {
    Watched watched;
    watched.take_all({0, 1, 2});
    watched.doubt();
    EXPECT_EQ(watched.take_all({3, 4}), (Verdicts{Verdict::unconfirmed, Verdict::good}));
}

TEST(CounterWatch, TwoSendersInTurnAreNeverBelieved) {
    Watched watched;
    for (std::uint64_t count = 0; count < 32; ++count) {
        EXPECT_NE(watched.take(count % 16), Verdict::good);
        EXPECT_NE(watched.take((count + 2) % 16), Verdict::good);
    }
}

}  // namespace
}  // namespace tribus
