#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "transports/codecs/authenticated/receiver.h"
#include "transports/codecs/authenticated/sender.h"

/// Both ends of an authenticated link, and somebody on the way. Keys and MACs of the literal bytes
/// were computed with Python's hmac and `openssl mac`.
namespace tribus::test::link_test {
namespace {

using namespace authenticated;
using namespace std::chrono_literals;

constexpr std::string_view kLink = "can 0x300 boat";
constexpr std::uint32_t kSession = 0x0A0B0C;
constexpr std::uint32_t kOtherSession = 0x0A0B0D;
constexpr RandomSeed kSeed{0x20, 0x21, 0x22, 0x23, 0x24, 0x25, 0x26, 0x27,
                           0x28, 0x29, 0x2A, 0x2B, 0x2C, 0x2D, 0x2E, 0x2F};
constexpr RandomSeed kOtherSeed{1, 2, 3};

/// A sender's session is the first bytes of its seed.
constexpr RandomSeed seed_of(std::uint32_t session) {
    return {static_cast<std::uint8_t>(session), static_cast<std::uint8_t>(session >> 8U),
            static_cast<std::uint8_t>(session >> 16U)};
}

SecretKey counted_secret() {
    SecretKey secret{};
    for (std::size_t i = 0; i < secret.size(); ++i) {
        secret[i] = static_cast<std::uint8_t>(i);
    }
    return secret;
}

Instant at(Duration time) {
    return Instant{} + 1h + time;
}

template <class Message>
std::vector<std::uint8_t> copy_of(const Message& message) {
    return {message.begin(), message.end()};
}

constexpr std::string_view kHelloDigits = "0c0b0a000000000042626cb5f71253f64d6ba7020bbb780b";
constexpr std::string_view kChallengeDigits =
    "3de0fc3d0000000098729a45e630923943db1cf2d1e4f444d570af281a9eb78d";
constexpr std::string_view kSnapshotDigits =
    "006196000c0b0a00c8000000401fd0206022f02380251027a028302ac02b502de02e7030003290332035b036"
    "ffffffff8875b7ccc73f90b99325075a5e8cbfff";

/// 16 channels from 1000 us in steps of 50 us, good, link quality 97 %.
ChannelFrame sticks(Instant received) {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < 16; ++channel) {
        frame.set(channel,
                  Pulse::from_microseconds(1000 + 50 * static_cast<std::int64_t>(channel)));
    }
    frame.failsafe = false;
    frame.frame_lost = false;
    frame.link_quality = 97;
    frame.received = received;
    return frame;
}

/// A link with everything that its ends sent.
class AuthenticatedLink : public ::testing::Test {
  protected:
    static LinkMacs macs() { return {counted_secret(), kLink}; }

    static std::vector<std::uint8_t> hello(std::uint32_t session) {
        Sender sender(macs(), seed_of(session));
        HelloMessage message{};
        EXPECT_TRUE(sender.write_hello(message, at(0ms)));
        return copy_of(message);
    }
    static std::vector<std::uint8_t> answer(Receiver& receiver, Instant now) {
        ChallengeMessage message{};
        return receiver.answer(message, now) ? copy_of(message) : std::vector<std::uint8_t>{};
    }
    /// What the receiver answers to a hello.
    static std::vector<std::uint8_t> challenge(Receiver& receiver, Instant now,
                                               std::uint32_t session = kSession) {
        EXPECT_FALSE(receiver.next(hello(session), now));
        return answer(receiver, now);
    }
    std::vector<std::uint8_t> challenge(Instant now, std::uint32_t session = kSession) {
        return challenge(receiver_, now, session);
    }
    static std::vector<std::uint8_t> snapshot(Sender& sender, Instant now, Duration age = 0ms) {
        SnapshotMessage message{};
        return sender.write(sticks(now - age), message, now) ? copy_of(message)
                                                             : std::vector<std::uint8_t>{};
    }
    /// A challenge that arrives at once.
    void ask(Instant now) { ASSERT_TRUE(sender_.hear(challenge(now), now)); }
    std::uint64_t refused(std::string_view name) const {
        const auto counts = receiver_.rejected();
        const auto found = std::ranges::find(counts, name, &NamedCount::name);
        return found == counts.end() ? 0 : found->count;
    }

    Receiver receiver_{macs(), std::nullopt, kSeed};
    Sender sender_{macs(), seed_of(kSession)};
};

TEST_F(AuthenticatedLink, SaysHelloWithTheseBytes) {
    EXPECT_EQ(hello(kSession), from_hex(kHelloDigits));
}

TEST_F(AuthenticatedLink, ChallengesWithTheseBytes) {
    EXPECT_EQ(challenge(at(0ms)), from_hex(kChallengeDigits));
}

TEST_F(AuthenticatedLink, SendsSnapshotsWithTheseBytes) {
    ask(at(0ms));
    EXPECT_EQ(snapshot(sender_, at(2ms), 1500us), from_hex(kSnapshotDigits));
}

TEST_F(AuthenticatedLink, PublishesWhatWasSent) {
    ask(at(0ms));
    const auto frame = receiver_.next(snapshot(sender_, at(2ms), 1500us), at(2ms));
    ASSERT_TRUE(frame);
    EXPECT_TRUE(frame->same_content(sticks(at(0ms))));
    EXPECT_EQ(frame->link_quality, 97);
    EXPECT_LE(frame->received, at(500us)) << "never younger than it is";
    EXPECT_GE(frame->received, at(500us) - 30us);
}

TEST_F(AuthenticatedLink, SendsNoSnapshotBeforeAChallenge) {
    EXPECT_TRUE(snapshot(sender_, at(0ms)).empty());
}

TEST_F(AuthenticatedLink, SaysHelloEach100MillisecondsUntilItIsChallengedAndAfterChallengesStop) {
    std::vector<Duration> said;
    HelloMessage message{};
    for (Duration now = 0ms; now < 1000ms; now += 10ms) {
        if (now == 250ms) {
            ask(at(now));
        }
        if (sender_.write_hello(message, at(now))) {
            said.push_back(now);
        }
    }
    EXPECT_EQ(said,
              (std::vector<Duration>{0ms, 100ms, 200ms, 460ms, 560ms, 660ms, 760ms, 860ms, 960ms}));
}

TEST_F(AuthenticatedLink, ChallengesAgainAtMostEach50MillisecondsWhileSnapshotsCount) {
    ask(at(0ms));
    std::vector<Duration> asked;
    for (Duration now = 10ms; now <= 200ms; now += 10ms) {
        EXPECT_TRUE(receiver_.next(snapshot(sender_, at(now)), at(now)));
        const auto question = answer(receiver_, at(now));
        if (!question.empty()) {
            asked.push_back(now);
            EXPECT_TRUE(sender_.hear(question, at(now)));
        }
    }
    EXPECT_EQ(asked, (std::vector<Duration>{50ms, 100ms, 150ms, 200ms}));
}

TEST_F(AuthenticatedLink, AnswersOnlyWhoHasTheKey) {
    auto forged = hello(kSession);
    for (std::size_t bit = 0; bit < 8 * forged.size(); ++bit) {
        forged[bit / 8] = static_cast<std::uint8_t>(forged[bit / 8] ^ 1U << bit % 8);
        EXPECT_FALSE(receiver_.next(forged, at(0ms)));
        EXPECT_TRUE(answer(receiver_, at(0ms)).empty()) << bit;
        forged[bit / 8] = static_cast<std::uint8_t>(forged[bit / 8] ^ 1U << bit % 8);
    }
    EXPECT_EQ(refused("forged"), 8 * forged.size());
}

/// Who repeats a recorded hello can neither use up the challenges nor make the receiver flood.
TEST_F(AuthenticatedLink, AnswersRepeatedHellosRarelyAndWithTheSameChallenge) {
    ask(at(0ms));
    const auto early = snapshot(sender_, at(1ms));
    std::size_t answers = 0;
    std::set<std::vector<std::uint8_t>> different;
    for (Duration now = 1ms; now <= 900ms; now += 100us) {
        const auto question = challenge(at(now));
        if (!question.empty()) {
            ++answers;
            different.insert(question);
        }
    }
    EXPECT_LE(answers, 450U);
    EXPECT_GE(answers, 400U);
    EXPECT_LE(different.size(), 18U + 1U);
    EXPECT_TRUE(receiver_.next(early, at(901ms))) << "the first challenge still counts";
}

TEST_F(AuthenticatedLink, SaysNothingWhenChallengesStop) {
    ask(at(0ms));
    EXPECT_FALSE(snapshot(sender_, at(655ms)).empty());
    EXPECT_TRUE(snapshot(sender_, at(656ms)).empty());
}

/// Each bit of a message counts, and a part of the MAC is none.
TEST_F(AuthenticatedLink, RefusesEverySnapshotWithAChangedBit) {
    ask(at(0ms));
    const auto right = snapshot(sender_, at(2ms));
    for (std::size_t bit = 0; bit < 8 * right.size(); ++bit) {
        auto wrong = right;
        wrong[bit / 8] = static_cast<std::uint8_t>(wrong[bit / 8] ^ 1U << bit % 8);
        EXPECT_FALSE(receiver_.next(wrong, at(2ms))) << bit;
    }
    for (std::size_t length = 0; length < right.size(); ++length) {
        EXPECT_FALSE(receiver_.next(std::span(right).first(length), at(2ms))) << length;
    }
    EXPECT_TRUE(receiver_.next(right, at(2ms)));
    EXPECT_EQ(refused("no_key"), right.size() - 1);
    EXPECT_EQ(refused("forged") + refused("no_challenge"), 8 * right.size() + 1)
        << "one length is that of a hello";
    EXPECT_EQ(refused("no_challenge"), 8U) << "the bits of the challenge's number";
}

TEST_F(AuthenticatedLink, RefusesEveryChallengeWithAChangedBit) {
    const auto right = challenge(at(0ms));
    for (std::size_t bit = 0; bit < 8 * right.size(); ++bit) {
        auto wrong = right;
        wrong[bit / 8] = static_cast<std::uint8_t>(wrong[bit / 8] ^ 1U << bit % 8);
        EXPECT_FALSE(sender_.hear(wrong, at(0ms))) << bit;
    }
    EXPECT_TRUE(sender_.hear(right, at(0ms)));
}

TEST_F(AuthenticatedLink, RefusesAnotherKeyAnotherLinkAndItsOwnMessages) {
    SecretKey other = counted_secret();
    other[31] ^= 1U;
    for (const LinkMacs& wrong :
         {LinkMacs(other, kLink), LinkMacs(counted_secret(), "can 0x310 boat")}) {
        Sender stranger(wrong, seed_of(kSession));
        EXPECT_FALSE(stranger.hear(challenge(at(0ms)), at(0ms)));
        HelloMessage message{};
        ASSERT_TRUE(stranger.write_hello(message, at(0ms)));
        EXPECT_FALSE(receiver_.next(message, at(0ms)));
        EXPECT_TRUE(answer(receiver_, at(10ms)).empty());
    }
    EXPECT_FALSE(receiver_.next(challenge(at(100ms)), at(100ms))) << "reflected";
    EXPECT_FALSE(sender_.hear(hello(kSession), at(100ms))) << "reflected";
    ask(at(200ms));
    EXPECT_FALSE(sender_.hear(snapshot(sender_, at(201ms)), at(201ms))) << "reflected";
}

/// A recorded challenge means nothing to a sender that has started again.
TEST_F(AuthenticatedLink, HearsNoChallengeToAnotherSession) {
    EXPECT_FALSE(sender_.hear(challenge(at(0ms), kOtherSession), at(0ms)));
}

TEST_F(AuthenticatedLink, TakesAnOldKeyBesideTheNewOneWhileKeysAreChanged) {
    SecretKey other = counted_secret();
    other[0] ^= 1U;
    const LinkMacs changed(other, kLink);
    Receiver receiver(changed, macs(), kSeed);
    for (const auto& [keys, session, begun] :
         {std::tuple(macs(), kSession, 0ms), std::tuple(changed, kOtherSession, 1000ms)}) {
        Sender sender(keys, seed_of(session));
        HelloMessage message{};
        ASSERT_TRUE(sender.write_hello(message, at(begun)));
        EXPECT_FALSE(receiver.next(message, at(begun)));
        ASSERT_TRUE(sender.hear(answer(receiver, at(begun)), at(begun)));
        for (const Duration later : {60ms, 120ms, 180ms}) {
            const Instant now = at(begun + later);
            EXPECT_TRUE(receiver.next(snapshot(sender, now), now));
            EXPECT_TRUE(sender.hear(answer(receiver, now), now)) << "asked with its own key";
        }
    }
    ask(at(2000ms));
    EXPECT_FALSE(Receiver(changed, std::nullopt, kSeed).next(hello(kSession), at(0ms)));
}

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
    std::size_t published = 0;
    for (int round = 0; round < 100; ++round) {
        const Instant now = at(round * 10ms);
        if (round % 10 == 0) {
            ASSERT_TRUE(sender_.hear(challenge(now), now));
            ASSERT_TRUE(other.hear(challenge(now + 2ms, kOtherSession), now + 2ms));
        }
        published += receiver_.next(snapshot(sender_, now), now) ? 1U : 0U;
        published += receiver_.next(snapshot(other, now + 5ms), now + 5ms) ? 1U : 0U;
    }
    EXPECT_EQ(published, 1U) << "the first one, before the other was there";
    // One of them ends: the other gets through without a hand.
    std::size_t alone = 0;
    for (int round = 100; round < 200; ++round) {
        const Instant now = at(round * 10ms);
        if (round % 10 == 0) {
            ASSERT_TRUE(other.hear(challenge(now, kOtherSession), now));
        }
        alone += receiver_.next(snapshot(other, now), now) ? 1U : 0U;
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
}  // namespace tribus::test::link_test
