#include <algorithm>
#include <chrono>
#include <cstdint>
#include <numeric>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/fixed_clock.h"
#include "tests/unit/transports/codecs/mavlink/mavlink_messages.h"
#include "transports/codecs/mavlink/mavlink.h"
#include "transports/codecs/mavlink/signature.h"

/// What the times of signed messages tell of their delay, and which times are refused.
namespace tribus::test::mavlink_delay_test {
namespace {

using namespace std::chrono_literals;

/// 2026-11-26, 00:00:00 UTC.
constexpr Duration kDay = 1795651200s;
constexpr Instant kStart{1000s};
constexpr Duration kPeriod = 20ms;
constexpr int kHeld = 500;

SecretKey key() {
    SecretKey secret{};
    std::iota(secret.begin(), secret.end(), std::uint8_t{1});
    return secret;
}

/// A sender and a receiver whose clocks are right.
class MavlinkDelay : public ::testing::Test {
  protected:
    MavlinkDelay() {
        signer_.use_clock(of_sender_);
        decoder_.use_clock(of_receiver_);
    }

    Bytes sent(Instant at, std::uint32_t id = 70, std::uint8_t extra = 124) {
        return sent_by(signer_, at, id, extra);
    }
    static Bytes sent_by(MavlinkSigner& signer, Instant at, std::uint32_t id = 70,
                         std::uint8_t extra = 124) {
        Bytes frame = message_2(id, extra, {0xDC, 0x05, 0xDC, 0x05}, {.flags = 1});
        signer.sign(frame, frame.size() - 13, at);
        return frame;
    }
    Bytes heartbeat(Instant at) { return sent(at, 0, 50); }
    /// The age of what the bytes publish when they come at `at`.
    std::optional<Duration> age(const Bytes& bytes, Instant at) {
        std::span<const std::uint8_t> rest(bytes);
        DecodedFrame frame;
        return decoder_.next(rest, at, frame) ? std::optional(decoder_.age()) : std::nullopt;
    }
    bool counts(const Bytes& bytes, Instant at) { return age(bytes, at).has_value(); }
    std::uint64_t refused(std::string_view cause) const { return count_of(decoder_, cause); }

    FixedClock of_sender_{kDay, kStart};
    FixedClock of_receiver_{kDay, kStart};
    MavlinkSigner signer_{key(), 0};
    MavlinkDecoder decoder_{{.key = key()}};
};

TEST_F(MavlinkDelay, IsSeenInAStreamThatWasHeldBackForAnHour) {
    EXPECT_TRUE(counts(sent(kStart), kStart));
    std::vector<Bytes> held;
    for (int i = 1; i <= kHeld; ++i) {
        held.push_back(sent(kStart + i * kPeriod));
    }
    int played = 0;
    for (int i = 1; i <= kHeld; ++i) {
        played += counts(held.at(static_cast<std::size_t>(i) - 1), kStart + 1h + i * kPeriod);
    }
    EXPECT_EQ(played, 0) << "in order, at its own pace";
    EXPECT_EQ(refused("late"), static_cast<std::uint64_t>(kHeld));
    EXPECT_TRUE(counts(sent(kStart + 2h), kStart + 2h)) << "the sender itself, without a hand";
}

/// The heartbeat has a time just behind that of the channels, and is sent with them.
TEST_F(MavlinkDelay, IsSeenInAHeldStreamAlsoWhereItsHeartbeatsAreHeldFromTheFirstOneOn) {
    EXPECT_TRUE(counts(sent(kStart), kStart));
    std::vector<Bytes> held{heartbeat(kStart)};
    for (int i = 1; i <= kHeld; ++i) {
        held.push_back(sent(kStart + i * kPeriod));
        if (i % 50 == 0) {
            held.push_back(heartbeat(kStart + i * kPeriod));
        }
    }
    int played = 0;
    Instant now = kStart + 1h;
    for (const Bytes& bytes : held) {
        played += counts(bytes, now);
        now += kPeriod;
    }
    EXPECT_EQ(played, 0);
}

TEST_F(MavlinkDelay, IsTheAgeOfTheValues) {
    for (Duration now = 0ms; now < 1s; now += kPeriod) {
        EXPECT_LE(age(sent(kStart + now), kStart + now + 5ms).value_or(1h), 0ms);
    }
    const auto late = age(sent(kStart + 1s), kStart + 1s + 305ms);
    ASSERT_TRUE(late);
    EXPECT_GE(*late, 299ms);
    EXPECT_LE(*late, 300ms);
    EXPECT_FALSE(counts(sent(kStart + 1s + kPeriod), kStart + 2s + 50ms));
    EXPECT_EQ(refused("late"), 1U);
    EXPECT_LE(age(sent(kStart + 3s), kStart + 3s + 5ms).value_or(1h), 2ms);
}

/// The C library of MAVLink, pymavlink and ArduPilot add one to the time of each message, and look
/// at a clock when they start.
TEST_F(MavlinkDelay, IsNotToldOfASenderThatCountsItsMessages) {
    Duration oldest{};
    for (Duration now = 0s; now < 600s; now += kPeriod) {
        const auto told = age(sent(kStart), kStart + now);
        ASSERT_TRUE(told) << std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
        oldest = std::max(oldest, *told);
    }
    EXPECT_LE(oldest, MavlinkVerifier::kCountedMessages * kPeriod);
    // It has looked at the clock, and counts on from there.
    EXPECT_EQ(age(sent(kStart + 600s), kStart + 600s), 0ms);
    for (Duration now = 600s; now < 601s; now += kPeriod) {
        EXPECT_TRUE(counts(sent(kStart + 600s), kStart + now + kPeriod));
    }
}

TEST_F(MavlinkDelay, GoesOnWithASenderWhoseClockIsSetBackAndIsRightAgain) {
    for (Duration now = 0s; now < 200s; now += kPeriod) {
        if (now == 10s) {
            of_sender_.set(kDay - 60s, kStart);
        }
        const auto told = age(sent(kStart + now), kStart + now);
        ASSERT_TRUE(told) << now.count();
        ASSERT_LE(*told, MavlinkVerifier::kCountedMessages * kPeriod);
    }
}

/// As far as programs that set a clock while it runs let it be slower or faster.
TEST_F(MavlinkDelay, IsNoneWithClocksThatDrift) {
    Instant begin = kStart;
    for (const std::int64_t parts : {2000, -2000}) {
        for (Duration now = 0s; now < 1h; now += 100ms) {
            ASSERT_LE(age(sent(begin + now), begin + now + now / parts).value_or(1h), 1ms) << parts;
        }
        begin += 2h;
        signer_ = MavlinkSigner(key(), 1);
        signer_.use_clock(of_sender_);
    }
}

/// As chronyd does by default. It slows the clock of instants, too.
constexpr Duration kFastBy = 1700ms;
constexpr auto kLookPeriod = 250ms;

/// How much such a clock has lost, `passed` after the beginning.
Duration lost(Duration passed) {
    return std::clamp<Duration>((passed - 10s) / 12, 0s, kFastBy);
}

TEST_F(MavlinkDelay, IsNoneWhereTheClockOfTheSenderIsSlowedByATwelfth) {
    of_sender_.set(kDay + kFastBy, kStart);
    for (Duration now = 0s; now < 100s; now += kPeriod) {
        if (now % kLookPeriod < kPeriod) {
            of_sender_.set_lost(lost(now));
        }
        const Bytes bytes = sent(kStart + now - lost(now));
        ASSERT_LE(age(bytes, kStart + now).value_or(1h), 25ms) << now.count();
    }
}

TEST_F(MavlinkDelay, IsNoneWhereTheClockOfTheReceiverIsMadeFasterByATwelfth) {
    of_receiver_.set(kDay - kFastBy, kStart);
    for (Duration now = 0s; now < 100s; now += kPeriod) {
        if (now % kLookPeriod < kPeriod) {
            of_receiver_.set_lost(-lost(now));
        }
        const Bytes bytes = sent(kStart + now);
        ASSERT_LE(age(bytes, kStart + now + lost(now)).value_or(1h), 25ms) << now.count();
    }
}

TEST_F(MavlinkDelay, IsNoneWhereTheClockOfTheSenderIsSetBackByLessThanHalfAMinute) {
    Instant begin = kStart;
    std::uint8_t link = 0;
    for (const Duration back : {500ms, 700ms, 800ms, 29'000ms}) {
        for (const Duration period : {20ms, 100ms, 1000ms}) {
            of_sender_.set(kDay, kStart);
            MavlinkSigner signer(key(), link++);
            signer.use_clock(of_sender_);
            begin += 1h;
            for (Duration now = 0s; now < 120s; now += period) {
                if (now == 10s) {
                    of_sender_.set(kDay - back, kStart);
                }
                const auto told = age(sent_by(signer, begin + now), begin + now);
                ASSERT_LE(told.value_or(1h), 1ms) << back.count() << " " << now.count();
            }
        }
    }
}

TEST_F(MavlinkDelay, CostsLessThanHalfASecondWhereTheClockOfTheSenderIsSetBackByAMinute) {
    Duration old{};
    for (Duration now = 0s; now < 200s; now += 100ms) {
        if (now == 10s) {
            of_sender_.set(kDay - 60s, kStart);
        }
        const auto told = age(sent(kStart + now), kStart + now);
        old += told && *told < 500ms ? 0ms : 100ms;
    }
    EXPECT_LT(old, 500ms);
}

/// A sender that was set back starts again without a loss later on.
TEST_F(MavlinkDelay, LetsASenderStartAgainThatWasSetBackAndHasReturnedToItsClock) {
    EXPECT_TRUE(counts(sent(kStart), kStart));
    of_sender_.set(kDay - 700ms, kStart);
    for (Duration now = 100ms; now < 25min; now += 100ms) {
        ASSERT_LE(age(sent(kStart + now), kStart + now).value_or(1h), 1ms);
    }
    MavlinkSigner again(key(), 0);
    again.use_clock(of_sender_);
    EXPECT_TRUE(counts(sent_by(again, kStart + 25min), kStart + 25min));
}

TEST_F(MavlinkDelay, IsNoneWhereAReloadComesAfterTheClockOfTheSenderIsSetBack) {
    EXPECT_TRUE(counts(sent(kStart), kStart));
    of_sender_.set(kDay - 20s, kStart);
    EXPECT_TRUE(counts(sent(kStart + 100ms), kStart + 100ms));
    MavlinkSigner reloaded(key(), 0);
    reloaded.use_clock(of_sender_);
    reloaded.continue_from(signer_);
    const auto told = age(sent_by(reloaded, kStart + 200ms), kStart + 200ms);
    EXPECT_LE(told.value_or(1h), 1ms);
}

TEST_F(MavlinkDelay, IsSeenInAHeldStreamAlsoWhereTheClockIsSlowed) {
    EXPECT_TRUE(counts(sent(kStart), kStart));
    of_receiver_.set_lost(100s);
    for (int i = 1; i <= kHeld; ++i) {
        EXPECT_FALSE(counts(sent(kStart + i * kPeriod), kStart + 10s + i * kPeriod));
    }
}

/// Messages that came meanwhile are read as if they had come when the pause began.
TEST_F(MavlinkDelay, IsNoneBehindAPauseOfTheReceiver) {
    for (Duration now = 0s; now < 1s; now += kPeriod) {
        EXPECT_TRUE(counts(sent(kStart + now), kStart + now));
    }
    for (Duration now = 1s; now < 1400ms; now += kPeriod) {
        EXPECT_TRUE(counts(sent(kStart + now), kStart + 1s));
    }
    EXPECT_LE(age(sent(kStart + 1400ms), kStart + 1400ms).value_or(1h), kPeriod);
}

TEST_F(MavlinkDelay, LetsNoStreamBeginMoreThanAMinuteAheadOfAClockThatIsSet) {
    for (const auto& [ahead, taken] : {std::pair<Duration, bool>{59s, true}, {61s, false}}) {
        MavlinkDecoder decoder({.key = key()});
        decoder.use_clock(of_receiver_);
        std::span<const std::uint8_t> rest;
        DecodedFrame frame;
        const FixedClock wrong(kDay + ahead, kStart);
        MavlinkSigner signer(key(), 0);
        signer.use_clock(wrong);
        const Bytes bytes = sent_by(signer, kStart);
        rest = bytes;
        EXPECT_EQ(decoder.next(rest, kStart, frame), taken);
        EXPECT_EQ(count_of(decoder, "ahead"), taken ? 0U : 1U);
    }
}

/// Recorded when the sender's clock was wrong.
TEST_F(MavlinkDelay, IsNotLockedOutByATimeFiveYearsAhead) {
    const FixedClock wrong(kDay + 24h * 365 * 5, kStart);
    MavlinkSigner ahead(key(), 0);
    ahead.use_clock(wrong);
    EXPECT_FALSE(counts(sent_by(ahead, kStart), kStart)) << "as the first one";
    EXPECT_TRUE(counts(sent(kStart), kStart));
    EXPECT_FALSE(counts(sent_by(ahead, kStart + 1s), kStart + 1s)) << "nor amid others";
    EXPECT_TRUE(counts(sent(kStart + 2s), kStart + 2s));
    EXPECT_EQ(refused("ahead"), 2U);
}

TEST_F(MavlinkDelay, TakesAnyTimeAheadOfAClockThatIsNotSet) {
    of_receiver_.set(kDay - 10h, kStart);
    of_receiver_.never_set();
    EXPECT_TRUE(counts(sent(kStart), kStart));
}

/// A clock that gets ahead of the other one little by little.
TEST_F(MavlinkDelay, CostsNoControlThatThereIs) {
    EXPECT_TRUE(counts(sent(kStart), kStart));
    for (int minute = 1; minute <= 5; ++minute) {
        of_receiver_.set(kDay - minute * 30s, kStart);
        EXPECT_TRUE(counts(sent(kStart + minute * 1min), kStart + minute * 1min));
    }
}

}  // namespace
}  // namespace tribus::test::mavlink_delay_test
