#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
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
constexpr std::uint32_t kLife = 0x11223344;
constexpr std::uint32_t kSession = 0x0A0B0C;

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

constexpr Nonce kNonce{0xA0, 0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0xA7};
constexpr std::string_view kChallengeDigits =
    "4433221100000000a0a1a2a3a4a5a6a7e38de204f3d20fb0c29d358fcfad0b74";
constexpr std::string_view kSnapshotDigits =
    "006196000c0b0a00c8000000401fd0206022f02380251027a028302ac02b502de02e7030003290332035b036"
    "ffffffff075934a408bd9b6cf9026417f23c6a16";

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
    LinkMacs macs() const { return {counted_secret(), kLink}; }

    std::vector<std::uint8_t> challenge(Instant now) {
        Nonce nonce = kNonce;
        nonce[7] = static_cast<std::uint8_t>(nonce[7] + challenges_++);
        ChallengeMessage message{};
        receiver_.challenge(nonce, message, now);
        return copy_of(message);
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

    Receiver receiver_{macs(), kLife};
    Sender sender_{macs(), kSession};
    unsigned challenges_ = 0;
};

TEST_F(AuthenticatedLink, ChallengesWithTheseBytes) {
    EXPECT_EQ(challenge(at(0ms)), from_hex(kChallengeDigits));
}

TEST_F(AuthenticatedLink, AnswersWithTheseBytes) {
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

TEST_F(AuthenticatedLink, SaysNothingBeforeAChallenge) {
    EXPECT_TRUE(snapshot(sender_, at(0ms)).empty());
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
    EXPECT_EQ(refused("length"), right.size());
    EXPECT_EQ(refused("forged") + refused("no_challenge"), 8 * right.size());
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
        Sender stranger(wrong, kSession);
        EXPECT_FALSE(stranger.hear(challenge(at(0ms)), at(0ms)));
    }
    EXPECT_FALSE(receiver_.next(challenge(at(0ms)), at(0ms))) << "reflected";
    ask(at(0ms));
    EXPECT_FALSE(sender_.hear(snapshot(sender_, at(1ms)), at(1ms))) << "reflected";
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
                Receiver receiver(macs(), kLife);
                Sender sender(macs(), kSession);
                ChallengeMessage message{};
                receiver.challenge(kNonce, message, at(0ms));
                ASSERT_TRUE(sender.hear(message, at(way_there)));
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
    Receiver again(macs(), kLife + 1);
    EXPECT_FALSE(again.next(recorded, at(20ms)));
    ChallengeMessage message{};
    again.challenge({1, 2, 3, 4, 5, 6, 7, 8}, message, at(20ms));
    EXPECT_FALSE(again.next(recorded, at(20ms)));
    ASSERT_TRUE(sender_.hear(message, at(20ms)));
    EXPECT_TRUE(again.next(snapshot(sender_, at(21ms)), at(21ms))) << "no hand is needed";
}

TEST_F(AuthenticatedLink, GoesOnWithASenderThatStartedAgain) {
    ask(at(0ms));
    EXPECT_TRUE(receiver_.next(snapshot(sender_, at(10ms)), at(10ms)));
    Sender again(macs(), kSession + 1);
    ASSERT_TRUE(again.hear(challenge(at(300ms)), at(300ms)));
    EXPECT_TRUE(receiver_.next(snapshot(again, at(301ms)), at(301ms)));
}

TEST_F(AuthenticatedLink, RefusesWhatASenderLeftOnTheWayBeforeItStartedAgain) {
    ask(at(0ms));
    const auto left = snapshot(sender_, at(1ms));
    Sender again(macs(), kSession + 1);
    ASSERT_TRUE(again.hear(challenge(at(100ms)), at(100ms)));
    EXPECT_TRUE(receiver_.next(snapshot(again, at(101ms)), at(101ms)));
    EXPECT_FALSE(receiver_.next(left, at(102ms)));
    EXPECT_FALSE(receiver_.next(left, at(500ms))) << "also when the new one is silent";
}

TEST_F(AuthenticatedLink, PublishesNothingOfTwoSendersThatTakeTurns) {
    Sender other(macs(), kSession + 1);
    std::size_t published = 0;
    for (int round = 0; round < 100; ++round) {
        const Instant now = at(round * 10ms);
        if (round % 10 == 0) {
            const auto question = challenge(now);
            ASSERT_TRUE(sender_.hear(question, now));
            ASSERT_TRUE(other.hear(question, now));
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
            ASSERT_TRUE(other.hear(challenge(now), now));
        }
        alone += receiver_.next(snapshot(other, now), now) ? 1U : 0U;
    }
    EXPECT_GE(alone, 50U) << "half a second later";
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
    EXPECT_EQ(frame->received, Instant{});
}

}  // namespace
}  // namespace tribus::test::link_test
