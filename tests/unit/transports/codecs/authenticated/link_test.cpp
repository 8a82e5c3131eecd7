#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/authenticated/link_bench.h"

/// The messages of an authenticated link: what they are, who is answered, what is refused.
namespace tribus::test::link_test {
namespace {

using namespace authenticated_link;

TEST_F(AuthenticatedLink, SaysHelloWithTheseBytes) {
    EXPECT_EQ(hello(kSession), from_hex(kHelloDigits));
}

TEST_F(AuthenticatedLink, ChallengesWithTheseBytes) {
    EXPECT_EQ(challenge(at(0ms)), from_hex(kChallengeDigits));
}

TEST_F(AuthenticatedLink, SendsSnapshotsWithTheseBytes) {
    ask(at(0ms));
    EXPECT_EQ(snapshot(sender_, at(2ms), 1500us), from_hex(kSnapshotDigits));
    EXPECT_EQ(snapshot(sender_, at(4ms), 1500us), from_hex(kNextSnapshotDigits));
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

/// Times of hellos before 2 s, of a sender that is challenged once.
std::vector<Duration> hellos_of(Sender& sender, Receiver& receiver, Duration challenged) {
    std::vector<Duration> said;
    HelloMessage message{};
    ChallengeMessage question{};
    for (Duration now = 0ms; now < 2s; now += 1ms) {
        const bool says = sender.write_hello(message, at(now));
        if (says) {
            said.push_back(now);
        }
        if (says && now >= challenged && said.size() > 1 && said[said.size() - 2] < challenged) {
            EXPECT_FALSE(receiver.next(message, at(now)));
            EXPECT_TRUE(receiver.answer(question, at(now)));
            EXPECT_TRUE(sender.hear(question, at(now)));
        }
    }
    return said;
}

TEST_F(AuthenticatedLink, SaysHelloEach75To125MillisecondsUntilItIsChallenged) {
    const auto said = hellos_of(sender_, receiver_, 2s);
    ASSERT_EQ(said.front(), 0ms);
    std::set<Duration> pauses;
    for (std::size_t i = 1; i < said.size(); ++i) {
        const Duration pause = said[i] - said[i - 1];
        EXPECT_GE(pause, 75ms);
        EXPECT_LE(pause, 125ms);
        pauses.insert(pause);
    }
    EXPECT_GE(said.size(), 17U);
    EXPECT_GE(pauses.size(), 8U) << "nobody can foresee the next one";
    Sender other(macs(), seed_of(kOtherSession));
    EXPECT_NE(hellos_of(other, receiver_, 2s), said);
}

TEST_F(AuthenticatedLink, SaysHelloAgainWhenChallengesStop) {
    const auto said = hellos_of(sender_, receiver_, 500ms);
    const auto challenged = std::ranges::lower_bound(said, Duration(500ms));
    ASSERT_NE(challenged, said.end());
    ASSERT_NE(challenged + 1, said.end());
    EXPECT_EQ(*(challenged + 1) - *challenged, 201ms);
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
    EXPECT_LE(answers, 1800U + Receiver::kAnswersAtOnce);
    EXPECT_GE(answers, 1700U);
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

/// Whatever the hellos of one session use up, another one is answered.
TEST_F(AuthenticatedLink, AnswersANewSessionWhateverHellosOfOthersAreRepeated) {
    for (int i = 0; i < 1000; ++i) {
        challenge(at(0ms), kOtherSession);
    }
    EXPECT_TRUE(challenge(at(0ms), kOtherSession).empty());
    EXPECT_FALSE(challenge(at(0ms)).empty());
}

/// On a bus many ask before the receiver answers.
TEST_F(AuthenticatedLink, AnswersEachWhoWaitsWhenThereIsTime) {
    for (std::uint32_t session = 1; session <= 80; ++session) {
        EXPECT_FALSE(receiver_.next(hello(session), at(0ms)));
    }
    std::size_t answers = 0;
    while (!answer(receiver_, at(0ms)).empty()) {
        ++answers;
    }
    EXPECT_EQ(answers, static_cast<std::size_t>(Receiver::kAnswersAtOnce));
    for (std::uint32_t session = 1; session <= 10; ++session) {
        EXPECT_FALSE(receiver_.next(hello(0x200000 + session), at(0ms)));
    }
    EXPECT_TRUE(answer(receiver_, at(0ms)).empty());
    for (int i = 1; i <= 10; ++i) {
        EXPECT_FALSE(answer(receiver_, at(i * Receiver::kAnswerPeriod)).empty()) << i;
    }
}

/// Who repeats recorded hellos keeps nobody from an answer whose snapshots count.
TEST_F(AuthenticatedLink, AnswersASnapshotThatCountsWhateverHellosAreRepeated) {
    ask(at(0ms));
    EXPECT_FALSE(challenge(at(59ms), kOtherSession).empty());
    EXPECT_TRUE(receiver_.next(snapshot(sender_, at(110ms)), at(110ms)));
    EXPECT_FALSE(receiver_.next(hello(kOtherSession), at(110ms)));
    const auto question = answer(receiver_, at(110ms));
    EXPECT_TRUE(sender_.hear(question, at(110ms))) << "the hello came behind it";
    EXPECT_FALSE(challenge(at(159ms), kOtherSession).empty());
    for (std::uint32_t session = 1; session <= 100; ++session) {
        challenge(at(160ms), session);
    }
    EXPECT_TRUE(receiver_.next(snapshot(sender_, at(160ms)), at(160ms)));
    EXPECT_TRUE(sender_.hear(answer(receiver_, at(160ms)), at(160ms))) << "they came before";
}

}  // namespace
}  // namespace tribus::test::link_test
