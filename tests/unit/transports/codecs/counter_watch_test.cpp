#include "transports/codecs/counter_watch.h"

#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::counter_watch_test {
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
    void restart_proof() { watch_.restart_proof(); }
    void require_long_proof() { watch_.require_long_proof(); }

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
    EXPECT_EQ(watched.take(5, false, 3 * kPeriod), Verdict::good);
    EXPECT_EQ(watched.take(9, false, 4 * kPeriod), Verdict::jump);
}

TEST(CounterWatch, GoingBackByOneIsAJump) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(1), Verdict::jump);
}

TEST(CounterWatch, AfterAJumpForWhichThereWasTimeProofIsDueFromThere) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(9, false, 7 * kPeriod), Verdict::jump);
    EXPECT_EQ(watched.take_all({10, 11}), (Verdicts{Verdict::unconfirmed, Verdict::good}));
}

TEST(CounterWatch, AfterAJumpForWhichThereWasNoTimeAllCountsAreDue) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(0), Verdict::jump);
    for (std::uint64_t count = 1; count < 16; ++count) {
        EXPECT_EQ(watched.take(count), Verdict::unconfirmed) << count;
    }
    EXPECT_EQ(watched.take(0), Verdict::good);
}

TEST(CounterWatch, WhatCameLateFromAQueueIsNoReasonToThinkThatThereWasNoTime) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(3, false, 10 * kPeriod), Verdict::good);
    EXPECT_EQ(watched.take(13), Verdict::jump);
    EXPECT_EQ(watched.take_all({14, 15}), (Verdicts{Verdict::unconfirmed, Verdict::good}));
}

TEST(CounterWatch, WhatWaitedInAQueueOverASilenceCostsNoMoreThanTheProof) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(3, false, 2 * kSilence), Verdict::unconfirmed);
    EXPECT_EQ(watched.take_all({4, 12, 13, 14}),
              (Verdicts{Verdict::unconfirmed, Verdict::jump, Verdict::unconfirmed, Verdict::good}));
}

TEST(CounterWatch, AnAdvanceByMoreThanOneNeedsTimeToo) {
    Watched watched;
    watched.take_all({0, 1, 2});
    EXPECT_EQ(watched.take(4), Verdict::jump);
}

TEST(CounterWatch, WhereNoTimesAreKnownTheCounterAloneDecides) {
    Watched watched;
    for (const std::uint64_t count : {0U, 1U}) {
        EXPECT_EQ(watched.take(count, false, {}), Verdict::unconfirmed);
    }
    EXPECT_EQ(watched.take(2, false, {}), Verdict::good);
    EXPECT_EQ(watched.take(5, false, {}), Verdict::good);
}

/// Returns how many frames are accepted when the counts of a ring repeat, one frame each `every`.
int believed_of_a_ring(CounterWatch& watch, std::uint64_t first, std::uint64_t length,
                       std::uint64_t values, Instant begin, Duration every) {
    int believed = 0;
    for (std::uint64_t frame = 0; frame < 2000; ++frame) {
        const std::uint64_t count = (first + frame % length) % values;
        const auto at = begin + every * static_cast<int>(frame);
        believed += watch.take(count, false, at) == Verdict::good ? 1 : 0;
    }
    return believed;
}

TEST(CounterWatch, OldFramesInARingAfterALiveSenderAreNeverBelievedUnlessTheyAreAllCounts) {
    for (const std::uint64_t values : {4U, 16U, 256U}) {
        for (std::uint64_t length = 2; length < values; ++length) {
            CounterWatch watch{
                {.values = values, .most_step = values == 4 ? 1U : 3U, .silence = kSilence}};
            Instant now{milliseconds(5000)};
            // The repeated frames are the last ones that were sent.
            for (std::uint64_t count = 0; count < 2 * values; ++count) {
                watch.take(count % values, false, now += milliseconds(20));
            }
            EXPECT_EQ(believed_of_a_ring(watch, 2 * values - length, length, values,
                                         now + milliseconds(20), milliseconds(20)),
                      0)
                << length << " of " << values;
        }
    }
}

TEST(CounterWatch, BelievesOnlyTheFirstRoundOfARingThatComesFirst) {
    for (std::uint64_t length = 3; length < 16; ++length) {
        CounterWatch watch{{.values = 16, .most_step = 3, .silence = kSilence}};
        EXPECT_EQ(
            believed_of_a_ring(watch, 5, length, 16, Instant{milliseconds(5000)}, milliseconds(20)),
            static_cast<int>(length) - 2)
            << length;
    }
}

TEST(CounterWatch, ASecondSenderThatIsRareIsBelievedOnceAtMost) {
    for (int offset = 0; offset < 20; ++offset) {
        CounterWatch watch{{.values = 16, .most_step = 3, .silence = kSilence}};
        int believed = 0;
        std::uint64_t other = 0;
        for (std::uint64_t frame = 0; frame < 900; ++frame) {
            const Instant now{milliseconds(5000 + 20 * frame)};
            watch.take(frame % 16, false, now);
            if (frame >= 100 && frame % 5 == 0) {
                const Verdict verdict = watch.take(other++ % 16, false, now + milliseconds(offset));
                believed += verdict == Verdict::good ? 1 : 0;
            }
        }
        EXPECT_LE(believed, 1) << offset;
    }
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
    for (std::uint64_t count = 3; count < 18; ++count) {
        EXPECT_EQ(watched.take(count % 16), Verdict::unconfirmed) << count;
    }
    EXPECT_EQ(watched.take(2), Verdict::good);
}

TEST(CounterWatch, ASecondBreakSoonMakesTheProofLongerThanWhatLayBetween) {
    Watched watched;
    watched.take_all({0, 1, 2});
    watched.require_long_proof();
    for (std::uint64_t count = 3; count < 103; ++count) {
        watched.take(count % 16);
    }
    watched.require_long_proof();
    for (std::uint64_t count = 103; count < 203; ++count) {
        EXPECT_EQ(watched.take(count % 16), Verdict::unconfirmed) << count;
    }
    EXPECT_EQ(watched.take(203 % 16), Verdict::good);
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
    watched.restart_proof();
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
}  // namespace tribus::counter_watch_test
