#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "tests/support/dbc_maps.h"
#include "transports/codecs/dbc/dbc.h"

/// What a decoder accepts when there are several messages, and senders that stop, restart, hang or
/// are doubled.
namespace tribus::supervision_test {
namespace {

using namespace test;
using Bytes = std::vector<std::uint8_t>;

DbcDecoder decoder_of(std::string_view dbc, std::string_view signals,
                      std::string_view cycles = {}) {
    return DbcDecoder(received_map(dbc, signals, cycles));
}

constexpr std::string_view kBus = R"(
BO_ 1 Left: 2 A
 SG_ L : 0|8@1+ (1,0) [0|200] "" B
 SG_ LeftGood : 8|1@1+ (1,0) [0|1] "" B
BO_ 2 Right: 2 A
 SG_ R : 0|8@1+ (1,0) [0|200] "" B
 SG_ RightGood : 8|1@1+ (1,0) [0|1] "" B
BO_ 1797 Heartbeat: 1 A
 SG_ State : 0|8@1+ (1,0) [0|0] "" B
)";
constexpr std::string_view kTwo = R"({"Left": {"L": 1}, "Right": {"R": 2}})";
constexpr std::string_view kTwoGood =
    R"({"Left": {"L": 1, "LeftGood": {"flag": "good"}},
        "Right": {"R": 2, "RightGood": {"flag": "good"}}})";
constexpr std::string_view kGuarded = R"({"Left": {"L": 1}, "Heartbeat": {"State": {"fixed": 5}}})";

CanFrame left(std::uint8_t value, std::uint8_t good = 1) {
    return standard_frame(1, {value, good});
}
CanFrame right(std::uint8_t value, std::uint8_t good = 1) {
    return standard_frame(2, {value, good});
}
CanFrame heartbeat(std::uint8_t state = 5) {
    return standard_frame(1797, {state});
}

double value(const std::optional<ChannelFrame>& snapshot, std::size_t channel) {
    const auto pulse = snapshot ? snapshot->channel(channel) : std::nullopt;
    return pulse ? (pulse->microseconds() - 1000) / 5 : -1;
}

TEST(DbcDecoder, ASnapshotWaitsForAllItsMessagesAndIsAsOldAsTheOldest) {
    DbcDecoder decoder = decoder_of(kBus, kTwo);
    EXPECT_FALSE(decoder.next(left(10), at(0)));
    EXPECT_FALSE(decoder.next(left(11), at(3)));
    const auto snapshot = decoder.next(right(20), at(5));
    ASSERT_TRUE(snapshot);
    EXPECT_EQ(value(snapshot, 0), 11);
    EXPECT_EQ(value(snapshot, 1), 20);
    EXPECT_EQ(snapshot->received, at(3));
    EXPECT_FALSE(decoder.next(right(21), at(6))) << "left has not come again";
}

TEST(DbcDecoder, WhileOneMessageIsMissingThereIsNoSnapshot) {
    DbcDecoder decoder = decoder_of(kBus, kTwo);
    decoder.next(right(20), at(0));
    decoder.next(left(10), at(0));
    for (int time = 20; time < 1000; time += 20) {
        EXPECT_FALSE(decoder.next(left(10), at(time)));
    }
    const auto snapshot = decoder.next(right(20), at(1000));
    ASSERT_TRUE(snapshot);
    EXPECT_EQ(snapshot->received, at(980));
}

TEST(DbcDecoder, AMessageThatIsWaitedForIsJudgedByItsAgeOnly) {
    DbcDecoder decoder = decoder_of(kBus, kTwo);
    decoder.next(left(10), at(0));
    const auto snapshot = decoder.next(right(20), at(1000));
    ASSERT_TRUE(snapshot);
    EXPECT_TRUE(snapshot->good());
    EXPECT_EQ(snapshot->received, at(0));
}

TEST(DbcDecoder, BurstsAreNotMixedThoughItBeganWithinOne) {
    for (const std::string_view cycles :
         {std::string_view{}, std::string_view(R"({"Left": "20ms", "Right": "20ms"})")}) {
        DbcDecoder decoder = decoder_of(kBus, kTwo, cycles);
        decoder.next(right(0), at(1));
        int mixed = 0;
        int whole = 0;
        for (std::uint8_t burst = 1; burst <= 50; ++burst) {
            for (const auto& snapshot : {decoder.next(left(burst), at(20 * burst)),
                                         decoder.next(right(burst), at(20 * burst + 1))}) {
                mixed += snapshot && value(snapshot, 0) != value(snapshot, 1) ? 1 : 0;
                whole += snapshot && value(snapshot, 0) == value(snapshot, 1) ? 1 : 0;
            }
        }
        EXPECT_LE(mixed, 1) << cycles;
        EXPECT_GE(whole, 49) << cycles;
    }
}

TEST(DbcDecoder, MessagesAtAnyDistanceGiveASnapshotInEachCycle) {
    for (int distance = 0; distance < 20; ++distance) {
        DbcDecoder decoder = decoder_of(kBus, kTwo, R"({"Left": "20ms", "Right": "20ms"})");
        int snapshots = 0;
        for (int i = 0; i < 100; ++i) {
            snapshots += decoder.next(left(1), at(20 * i)) ? 1 : 0;
            snapshots += decoder.next(right(1), at(20 * i + distance)) ? 1 : 0;
        }
        EXPECT_GE(snapshots, 99) << distance;
    }
}

TEST(DbcDecoder, MessagesOfUnevenPaceNeverStarve) {
    for (int other = 5; other < 60; ++other) {
        DbcDecoder decoder = decoder_of(kBus, kTwo);
        Instant last = at(0);
        for (int time = 0; time < 6000; ++time) {
            bool any = time % 20 == 0 && decoder.next(left(1), at(time));
            any = (time % other == 0 && decoder.next(right(1), at(time))) || any;
            last = any ? at(time) : last;
            EXPECT_LE(at(time) - last, milliseconds(2 * std::max(20, other))) << other;
        }
    }
}

TEST(DbcDecoder, ASlowMessageIsNotWaitedForButMissedAfterThreeCycles) {
    DbcDecoder decoder = decoder_of(kBus, kTwo, R"({"Left": "20ms", "Right": "100ms"})");
    EXPECT_TRUE(decoder.next(left(10), at(0))->failsafe) << "right has never come";
    decoder.next(right(20), at(10));
    for (int time = 20; time <= 310; time += 10) {
        const auto snapshot = decoder.next(left(10), at(time));
        ASSERT_TRUE(snapshot);
        EXPECT_TRUE(snapshot->good()) << time;
        EXPECT_EQ(value(snapshot, 1), 20);
        EXPECT_EQ(snapshot->received, at(time));
    }
    EXPECT_TRUE(decoder.next(left(10), at(311))->failsafe);
    decoder.next(right(21), at(320));
    const auto again = decoder.next(left(10), at(330));
    EXPECT_TRUE(again->good());
    EXPECT_EQ(value(again, 1), 21);
}

TEST(DbcDecoder, ASlowMessageWithOptionalChannelsOnlyMayStayAway) {
    DbcDecoder decoder =
        decoder_of(kBus, R"({"Left": {"L": 1}, "Right": {"R": {"channel": 2, "optional": true}}})",
                   R"({"Left": "20ms", "Right": "100ms"})");
    decoder.next(right(20), at(0));
    EXPECT_EQ(value(decoder.next(left(10), at(20)), 1), 20);
    const auto without = decoder.next(left(10), at(340));
    ASSERT_TRUE(without);
    EXPECT_TRUE(without->good());
    EXPECT_FALSE(without->has(1)) << "an old value would be stale";
}

TEST(DbcDecoder, AMissingHeartbeatIsFailsafe) {
    DbcDecoder decoder = decoder_of(kBus, kGuarded, R"({"Heartbeat": "1s"})");
    EXPECT_TRUE(decoder.next(left(1), at(0))->failsafe) << "it has never come";
    EXPECT_FALSE(decoder.next(heartbeat(), at(1)));
    EXPECT_TRUE(decoder.next(left(1), at(3001))->good());
    EXPECT_TRUE(decoder.next(left(1), at(3002))->failsafe);
    decoder.next(heartbeat(), at(3003));
    EXPECT_TRUE(decoder.next(left(1), at(3004))->good());
}

TEST(DbcDecoder, AHeartbeatWithoutACycleMayBeMissingFor500Ms) {
    DbcDecoder decoder = decoder_of(kBus, kGuarded);
    decoder.next(heartbeat(), at(0));
    EXPECT_TRUE(decoder.next(left(1), at(500))->good());
    EXPECT_TRUE(decoder.next(left(1), at(501))->failsafe);
}

TEST(DbcDecoder, AHeartbeatThatSaysStoppedIsToldAtOnceAndStays) {
    DbcDecoder decoder = decoder_of(kBus, kGuarded);
    decoder.next(heartbeat(), at(0));
    decoder.next(left(1), at(0));
    const auto told = decoder.next(heartbeat(4), at(10));
    ASSERT_TRUE(told);
    EXPECT_TRUE(told->failsafe);
    EXPECT_FALSE(decoder.next(heartbeat(4), at(20))) << "told already";
    EXPECT_TRUE(decoder.next(left(1), at(30))->failsafe);
    decoder.next(heartbeat(), at(40));
    EXPECT_TRUE(decoder.next(left(1), at(50))->good());
}

TEST(DbcDecoder, FailsafeInOneMessageIsToldAtOnceAndHoldsWhileTheOthersSayGood) {
    DbcDecoder decoder = decoder_of(kBus, kTwoGood);
    decoder.next(left(1), at(0));
    EXPECT_TRUE(decoder.next(right(1), at(0))->good());
    EXPECT_TRUE(decoder.next(left(1, 0), at(20))->failsafe);
    EXPECT_TRUE(decoder.next(right(1), at(20))->failsafe);
    decoder.next(left(1), at(40));
    EXPECT_TRUE(decoder.next(right(1), at(40))->good());
}

constexpr std::string_view kCounted = R"(
BO_ 304 Command: 3 A
 SG_ Speed : 0|8@1+ (1,0) [0|200] "" B
 SG_ Count : 8|4@1+ (1,0) [0|15] "" B
 SG_ Check : 16|8@1+ (1,0) [0|255] "" B
)";
constexpr std::string_view kCountedSignals =
    R"({"Command": {"Speed": 1, "Count": {"counter": true}, "Check": {"checksum": "xor"}}})";

CanFrame command(unsigned count, std::uint8_t speed = 7) {
    const auto low = static_cast<std::uint8_t>(count % 16);
    return standard_frame(304, {speed, low, static_cast<std::uint8_t>(speed ^ low)});
}

class DbcCounterTest : public testing::Test {
  protected:
    /// Returns whether the frame is accepted 20 ms after the one before.
    bool believes(const CanFrame& frame) {
        time_ += 20;
        return decoder_.next(frame, at(time_)).has_value();
    }
    bool believes(unsigned count) { return believes(command(count)); }
    void get_started(unsigned count) {
        EXPECT_FALSE(believes(count));
        EXPECT_FALSE(believes(count + 1));
        EXPECT_TRUE(believes(count + 2));
    }

    DbcDecoder decoder_ = decoder_of(kCounted, kCountedSignals);
    int time_ = 0;
};

TEST_F(DbcCounterTest, IsBelievedWhenItHasGoneOnTwice) {
    get_started(14);
    EXPECT_TRUE(believes(17U));
    EXPECT_EQ(rejected(decoder_, "unconfirmed"), 2U);
}

TEST_F(DbcCounterTest, TwoLostFramesAreNoJump) {
    get_started(0);
    time_ += 40;
    EXPECT_TRUE(believes(5U));
    EXPECT_EQ(rejected(decoder_, "counter jump"), 0U);
}

TEST_F(DbcCounterTest, AJumpIsRefusedUntilItHasGoneOnTwice) {
    get_started(0);
    time_ += 60;
    EXPECT_FALSE(believes(6U));
    EXPECT_FALSE(believes(7U));
    EXPECT_TRUE(believes(8U));
    EXPECT_EQ(rejected(decoder_, "counter jump"), 1U);
}

TEST_F(DbcCounterTest, ASenderThatRestartsAfterAPauseIsBelievedAfterThreeFrames) {
    get_started(7);
    time_ += 250;
    get_started(0);
}

TEST_F(DbcCounterTest, ASenderThatRestartsWithoutAPauseIsBelievedWhenAllCountsHavePassed) {
    get_started(7);
    for (unsigned count = 0; count < 16; ++count) {
        EXPECT_FALSE(believes(count)) << count;
    }
    EXPECT_TRUE(believes(16U));
}

TEST_F(DbcCounterTest, OldFramesInARingAreNeverBelieved) {
    for (unsigned length = 2; length < 16; ++length) {
        for (unsigned count = 0; count < 40; ++count) {
            believes(count);
        }
        for (unsigned frame = 0; frame < 500; ++frame) {
            EXPECT_FALSE(believes(40 - length + frame % length)) << length << ", " << frame;
        }
    }
}

TEST_F(DbcCounterTest, ASecondSenderFiveTimesAsRareIsBelievedOnceAtMost) {
    for (int offset = 1; offset < 20; ++offset) {
        DbcDecoder decoder = decoder_of(kCounted, kCountedSignals);
        int of_the_other = 0;
        for (unsigned frame = 0; frame < 900; ++frame) {
            const int now = 20 * static_cast<int>(frame);
            decoder.next(command(frame, 7), at(now));
            if (frame >= 100 && frame % 5 == 0) {
                const auto taken = decoder.next(command(frame / 5, 8), at(now + offset));
                of_the_other += taken ? 1 : 0;
            }
        }
        EXPECT_LE(of_the_other, 1) << offset;
    }
}

TEST_F(DbcCounterTest, ASenderThatHangsIsNeverBelieved) {
    get_started(0);
    for (int i = 0; i < 100; ++i) {
        EXPECT_FALSE(believes(2U));
    }
    EXPECT_EQ(rejected(decoder_, "repeated"), 100U);
}

TEST_F(DbcCounterTest, AFrameThatTheBusRepeatsDoesNoHarm) {
    get_started(0);
    EXPECT_FALSE(believes(2U));
    EXPECT_TRUE(believes(3U));
}

TEST_F(DbcCounterTest, TheSameCountWithOtherDataIsAnotherSender) {
    get_started(0);
    EXPECT_FALSE(believes(command(2, 8)));
    for (unsigned count = 3; count < 18; ++count) {
        EXPECT_FALSE(believes(count)) << count;
    }
    EXPECT_TRUE(believes(18U));
}

TEST_F(DbcCounterTest, TwoSendersInTurnAreNeverBelieved) {
    for (unsigned ahead = 0; ahead < 16; ++ahead) {
        decoder_.next(command(0), at(time_ += 10'000));
        int believed = 0;
        for (unsigned count = 0; count < 100; ++count) {
            believed += believes(command(count, 7)) ? 1 : 0;
            believed += believes(command(count + ahead, 8)) ? 1 : 0;
        }
        EXPECT_LE(believed, 1) << ahead;
    }
}

TEST_F(DbcCounterTest, WhatComesFirstAfterSilenceMayHaveWaitedInAQueue) {
    get_started(0);
    time_ += 1000;
    get_started(3);
}

TEST_F(DbcCounterTest, AWrongChecksumIsNoFrameAtAll) {
    get_started(0);
    CanFrame damaged = command(3);
    damaged.data[0] ^= 0x10;
    EXPECT_FALSE(believes(damaged));
    EXPECT_EQ(rejected(decoder_, "checksum"), 1U);
    EXPECT_TRUE(believes(4U));
}

TEST_F(DbcCounterTest, GoingBackIsNoAdvanceOfASmallCounter) {
    DbcDecoder decoder =
        decoder_of(kCounted, R"({"Command": {"Speed": 1, "Count": {"counter": true, "most": 3}}})");
    int time = 0;
    for (const unsigned count : {0U, 1U, 2U, 3U, 0U}) {
        decoder.next(command(count), at(time += 20));
    }
    EXPECT_EQ(rejected(decoder, "counter jump"), 0U);
    EXPECT_FALSE(decoder.next(command(3), at(time + 20)));
    EXPECT_EQ(rejected(decoder, "counter jump"), 1U);
}

TEST_F(DbcCounterTest, AMostThatIsNotThatOfTheSenderIsAJump) {
    DbcDecoder decoder = decoder_of(
        kCounted, R"({"Command": {"Speed": 1, "Count": {"counter": true, "most": 14}}})");
    for (unsigned count = 0; count < 16; ++count) {
        EXPECT_EQ(decoder.next(command(count), at(20 * static_cast<int>(count))).has_value(),
                  count >= 2 && count <= 14);
    }
    EXPECT_EQ(rejected(decoder, "counter jump"), 1U);
}

TEST(DbcDecoder, AMessageRefusedForLongLeavesNoSnapshotOfTheOther) {
    DbcDecoder decoder = decoder_of(
        "BO_ 1 M: 2 A\n SG_ S : 0|8@1+ (1,0) [0|200] \"\" B\n SG_ C : 8|8@1+ (1,0) [0|0] \"\" B\n"
        "BO_ 2 N: 1 A\n SG_ T : 0|8@1+ (1,0) [0|200] \"\" B\n",
        R"({"M": {"S": 1, "C": {"checksum": "xor"}}, "N": {"T": 2}})");
    EXPECT_FALSE(decoder.next(standard_frame(2, {9}), at(0)));
    EXPECT_TRUE(decoder.next(standard_frame(1, {7, 7}), at(0)));
    for (int time = 20; time < 2000; time += 20) {
        EXPECT_FALSE(decoder.next(standard_frame(1, {7, 8}), at(time)));
        EXPECT_FALSE(decoder.next(standard_frame(2, {9}), at(time)));
    }
}

}  // namespace
}  // namespace tribus::supervision_test
