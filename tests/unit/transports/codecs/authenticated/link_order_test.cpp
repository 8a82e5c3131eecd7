#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/transports/codecs/authenticated/link_bench.h"

/// Order and age on an authenticated link: delays, repeats, restarts, two senders.
namespace tribus::test::link_order_test {
namespace {

using namespace authenticated_link;

TEST_F(AuthenticatedLink, TakesEachSnapshotOnceAndNoneOutOfOrder) {
    ask(at(0ms));
    const auto first = snapshot(sender_, at(10ms));
    const auto second = snapshot(sender_, at(20ms));
    ask(at(100ms));
    const auto third = snapshot(sender_, at(110ms));
    EXPECT_TRUE(receiver_.next(second, at(20ms)));
    EXPECT_FALSE(receiver_.next(first, at(21ms)));
    EXPECT_FALSE(receiver_.next(second, at(21ms)));
    EXPECT_TRUE(receiver_.next(third, at(110ms)));
    EXPECT_FALSE(receiver_.next(second, at(111ms)));
    EXPECT_EQ(refused("replayed"), 3U);
}

/// Whoever holds a message back makes it old, and never young.
TEST_F(AuthenticatedLink, TellsTheAgeOfWhatWasDelayedOnAnyWay) {
    for (const Duration way_there : {0ms, 1ms, 40ms, 300ms}) {
        for (const Duration held : {0ms, 7ms, 250ms}) {
            for (const Duration way_back : {0ms, 1ms, 40ms, 300ms}) {
                Receiver receiver(macs(), std::nullopt, kSeed);
                Sender sender(macs(), seed_of(kSession));
                ASSERT_TRUE(sender.hear(challenge(receiver, at(0ms)), at(way_there)));
                const Instant sent = at(way_there + held);
                const auto frame = receiver.next(snapshot(sender, sent, 3ms), sent + way_back);
                ASSERT_TRUE(frame);
                EXPECT_LE(frame->received, sent - 3ms);
                EXPECT_GE(frame->received, sent - 3ms - way_there - 1ms);
            }
        }
    }
}

TEST_F(AuthenticatedLink, RefusesAnAnswerToAChallengeThatIsASecondOld) {
    ask(at(0ms));
    const auto late = snapshot(sender_, at(10ms));
    EXPECT_FALSE(receiver_.next(late, at(1001ms)));
    EXPECT_EQ(refused("no_challenge"), 1U);
}

TEST_F(AuthenticatedLink, RoundsAgesUpAndHeldTimesDown) {
    EXPECT_EQ(age_steps(0ns), 0);
    EXPECT_EQ(age_steps(1ns), 1);
    EXPECT_EQ(age_steps(10us), 1);
    EXPECT_EQ(held_steps(19'999ns), 1);
    EXPECT_EQ(held_steps(20us), 2);
    EXPECT_EQ(age_steps(655'340us), 65534);
    EXPECT_EQ(age_steps(655'340us + 1ns), kNotTold);
    EXPECT_EQ(held_steps(1h), kNotTold);
}

/// A recorded conversation from before the start of either end.
TEST_F(AuthenticatedLink, RefusesWhatBelongsToAnEarlierLifeOfTheReceiver) {
    ask(at(0ms));
    const auto recorded = snapshot(sender_, at(10ms));
    Receiver again(macs(), std::nullopt, kOtherSeed);
    EXPECT_FALSE(again.next(recorded, at(20ms)));
    const auto question = challenge(again, at(201ms));
    EXPECT_FALSE(again.next(recorded, at(201ms)));
    ASSERT_TRUE(sender_.hear(question, at(201ms)));
    EXPECT_TRUE(again.next(snapshot(sender_, at(202ms)), at(202ms))) << "no hand is needed";
}

/// Bytes that are random at each call.
RandomSeed fresh_bytes() {
    static std::uint8_t calls = 0;
    return {++calls};
}

/// Its memory is that of before, so all that it does depends on the same bytes once more.
TEST_F(AuthenticatedLink, TakesNothingThatWasRecordedAfterItsReceiversMemoryWasRestored) {
    receiver_.use_random(fresh_bytes);
    Receiver restored = receiver_;
    HelloMessage greeting{};
    ASSERT_TRUE(sender_.write_hello(greeting, at(0ms)));
    EXPECT_FALSE(receiver_.next(greeting, at(0ms)));
    ASSERT_TRUE(sender_.hear(answer(receiver_, at(0ms)), at(0ms)));
    std::size_t live = 0;
    std::size_t again = 0;
    EXPECT_FALSE(restored.next(greeting, at(1h)));
    EXPECT_FALSE(answer(restored, at(1h)).empty());
    for (Duration now = 10ms; now < 10s; now += 10ms) {
        const auto message = snapshot(sender_, at(now));
        live += receiver_.next(message, at(now)) ? 1U : 0U;
        if (const auto question = answer(receiver_, at(now)); !question.empty()) {
            sender_.hear(question, at(now));
        }
        again += restored.next(message, at(1h + now)) ? 1U : 0U;
        answer(restored, at(1h + now));
    }
    EXPECT_EQ(live, 999U);
    EXPECT_EQ(again, 0U);
}

TEST_F(AuthenticatedLink, GoesOnWithASenderThatStartedAgain) {
    ask(at(0ms));
    EXPECT_TRUE(receiver_.next(snapshot(sender_, at(10ms)), at(10ms)));
    Sender again(macs(), seed_of(kOtherSession));
    ASSERT_TRUE(again.hear(challenge(at(300ms), kOtherSession), at(300ms)));
    EXPECT_TRUE(receiver_.next(snapshot(again, at(301ms)), at(301ms)));
}

TEST_F(AuthenticatedLink, RefusesWhatASenderLeftOnTheWayBeforeItStartedAgain) {
    ask(at(0ms));
    const auto left = snapshot(sender_, at(1ms));
    Sender again(macs(), seed_of(kOtherSession));
    ASSERT_TRUE(again.hear(challenge(at(100ms), kOtherSession), at(100ms)));
    EXPECT_TRUE(receiver_.next(snapshot(again, at(101ms)), at(101ms)));
    EXPECT_FALSE(receiver_.next(left, at(102ms)));
    EXPECT_FALSE(receiver_.next(left, at(500ms))) << "also when the new one is silent";
}

TEST_F(AuthenticatedLink, PublishesNothingOfTwoSendersThatTakeTurns) {
    Sender other(macs(), seed_of(kOtherSession));
    ASSERT_TRUE(sender_.hear(challenge(at(0ms)), at(0ms)));
    ASSERT_TRUE(other.hear(challenge(at(2ms), kOtherSession), at(2ms)));
    // Whether the snapshot of that sender counts. Both hear the answer.
    const auto counts = [&](Sender& from, Instant now) {
        const bool published = receiver_.next(snapshot(from, now), now).has_value();
        const auto question = answer(receiver_, now);
        sender_.hear(question, now);
        other.hear(question, now);
        return published;
    };
    std::size_t published = 0;
    for (Duration now = 10ms; now < 1s; now += 10ms) {
        published += counts(sender_, at(now)) ? 1U : 0U;
        published += counts(other, at(now + 5ms)) ? 1U : 0U;
    }
    EXPECT_EQ(published, 1U) << "the first one, before the other was there";
    // One of them ends: the other gets through without a hand.
    std::size_t alone = 0;
    for (Duration now = 1s; now < 2s; now += 10ms) {
        alone += counts(other, at(now)) ? 1U : 0U;
    }
    EXPECT_GE(alone, 50U) << "half a second later";
}

/// Otherwise snapshots that answer one challenge would have the same counters twice.
TEST_F(AuthenticatedLink, CountsSnapshotsOnWhenARecordedChallengeOfAnEarlierLifeIsRepeated) {
    const auto old_life = challenge(at(0ms));
    Receiver again(macs(), std::nullopt, kOtherSeed);
    const auto question = challenge(again, at(1000ms));
    ASSERT_TRUE(sender_.hear(question, at(1000ms)));
    EXPECT_TRUE(again.next(snapshot(sender_, at(1001ms)), at(1001ms)));
    const auto delayed = snapshot(sender_, at(1002ms));
    EXPECT_FALSE(sender_.hear(old_life, at(1200ms))) << "its receiver is there";
    ASSERT_TRUE(sender_.hear(old_life, at(1201ms)));
    ASSERT_TRUE(sender_.hear(question, at(1402ms)));
    EXPECT_TRUE(again.next(snapshot(sender_, at(1403ms)), at(1403ms)));
    EXPECT_FALSE(again.next(delayed, at(1404ms))) << "older values behind newer ones";
}

TEST_F(AuthenticatedLink, GoesOnWhenTheCounterComesRoundAndAfterALongSilence) {
    ask(at(0ms));
    std::size_t published = 0;
    constexpr int kSnapshots = 70'000;
    for (int i = 1; i <= kSnapshots; ++i) {
        const Instant now = at(i * 2ms);
        published += receiver_.next(snapshot(sender_, now), now) ? 1U : 0U;
        if (const auto question = answer(receiver_, now); !question.empty()) {
            sender_.hear(question, now);
        }
    }
    EXPECT_EQ(published, static_cast<std::size_t>(kSnapshots));
    // 40,000 snapshots that nobody receives: more than half of the values of the counter.
    ask(at(200s));
    for (int i = 0; i < 40'000; ++i) {
        snapshot(sender_, at(200s));
    }
    EXPECT_TRUE(receiver_.next(snapshot(sender_, at(200s)), at(200s)));
}

/// A repeated challenge would let its sender believe that it is young.
TEST_F(AuthenticatedLink, HearsEachChallengeOnce) {
    const auto question = challenge(at(0ms));
    EXPECT_TRUE(sender_.hear(question, at(0ms)));
    EXPECT_FALSE(sender_.hear(question, at(400ms)));
    const auto frame = receiver_.next(snapshot(sender_, at(400ms)), at(400ms));
    ASSERT_TRUE(frame);
    EXPECT_GE(frame->received, at(400ms) - 1ms);
}

TEST_F(AuthenticatedLink, PresetsHaveNoAge) {
    ask(at(0ms));
    ChannelFrame preset = sticks(Instant{});
    preset.failsafe = true;
    SnapshotMessage message{};
    ASSERT_TRUE(sender_.write(preset, message, at(1ms)));
    const auto frame = receiver_.next(message, at(1ms));
    ASSERT_TRUE(frame);
    EXPECT_TRUE(frame->failsafe);
    EXPECT_LE(frame->received, at(1ms));
    EXPECT_GE(frame->received, at(0ms));
}

/// The highest age stands for every greater one, too.
TEST_F(AuthenticatedLink, ValuesThatAreTooOldToTellAreOld) {
    ask(at(0ms));
    const auto frame = receiver_.next(snapshot(sender_, at(1ms), 10s), at(1ms));
    ASSERT_TRUE(frame);
    EXPECT_LE(frame->received, at(1ms) - 655ms);
}

}  // namespace
}  // namespace tribus::test::link_order_test
