#include "transports/codecs/line_pauses.h"

#include <gtest/gtest.h>

#include <chrono>

namespace tribus::line_pauses_test {
namespace {

using namespace std::chrono_literals;

/// 100000 baud 8E2.
constexpr Duration kByteTime = 120us;

Instant at(Duration since_start) {
    return Instant(since_start);
}

TEST(LinePauses, NothingIsKnownOfTheTimeBeforeTheFirstRead) {
    LinePauses pauses(kByteTime);
    EXPECT_FALSE(pauses.before(25, at(10s), 0));
}

TEST(LinePauses, WhatIsLongerThanTheBytesWereOnTheWireIsAPause) {
    LinePauses pauses(kByteTime);
    pauses.before(25, at(3ms), 0);
    EXPECT_TRUE(pauses.before(25, at(17ms), 0));
}

TEST(LinePauses, BytesThatWereOnTheWireAllTheTimeAreNone) {
    LinePauses pauses(kByteTime);
    pauses.before(1, at(0ms), 0);
    EXPECT_FALSE(pauses.before(23, at(23 * kByteTime), 1)) << "the reader slept meanwhile";
    EXPECT_FALSE(pauses.before(1, at(24 * kByteTime + 1ms), 24)) << "1 ms late";
    EXPECT_TRUE(pauses.before(1, at(26 * kByteTime + 2ms), 0));
}

TEST(LinePauses, TimeInWhichNobodyReadIsNone) {
    LinePauses pauses(kByteTime);
    pauses.before(10, at(0ms), 0);
    pauses.forget();
    EXPECT_FALSE(pauses.before(15, at(2s), 10));
    EXPECT_TRUE(pauses.before(25, at(2014ms), 0));
}

TEST(LinePauses, WhereTheTimeOfAByteIsNotKnownThereAreNone) {
    LinePauses pauses(Duration::zero());
    pauses.before(25, at(0ms), 0);
    EXPECT_FALSE(pauses.before(25, at(1s), 0));
}

/// Reads of 25-byte frames every 14 ms. Each frame comes in two reads, 5 ms apart.
class TornFrames {
  public:
    /// Returns whether a pause was found before the first part and before the second.
    std::pair<bool, bool> next() {
        const bool first = pauses_.before(10, at(now_), 0);
        const bool second = pauses_.before(15, at(now_ + 5ms), 10);
        if (!second) {
            pauses_.frame_came(25 * count_, 25);
        }
        ++count_;
        now_ += 14ms;
        return {first, second};
    }
    void whole(int frames) {
        for (int i = 0; i < frames; ++i) {
            pauses_.before(25, at(now_), 0);
            pauses_.frame_came(25 * count_, 25);
            ++count_;
            now_ += 14ms;
        }
    }

  private:
    LinePauses pauses_{kByteTime};
    Duration now_{};
    std::uint64_t count_ = 0;
};

TEST(LinePauses, FramesThatGoOnBehindPausesShowThatThePortTearsThem) {
    TornFrames frames;
    frames.whole(2);
    EXPECT_TRUE(frames.next().second);
    EXPECT_TRUE(frames.next().second);
    frames.next();
    const auto [first, second] = frames.next();
    EXPECT_TRUE(first) << "the pause between frames is longer";
    EXPECT_FALSE(second);
}

TEST(LinePauses, WhatAPortDidOnceIsForgotten) {
    TornFrames frames;
    frames.whole(2);
    for (int i = 0; i < 4; ++i) {
        frames.next();
    }
    EXPECT_FALSE(frames.next().second);
    frames.whole(600);
    EXPECT_TRUE(frames.next().second);
}

TEST(LinePauses, FramesThatAreCutOffShowNothingOfThePort) {
    LinePauses pauses(kByteTime);
    Duration now{};
    for (std::uint64_t count = 0; count < 50; ++count, now += 28ms) {
        EXPECT_EQ(pauses.before(20, at(now), 0), count != 0);
        EXPECT_TRUE(pauses.before(25, at(now + 14ms), 20));
        pauses.frame_came(45 * count + 20, 25);
    }
}

TEST(LinePauses, FramesTornForLongerThanAnyPortHoldsBytesBackShowNothingOfThePort) {
    LinePauses pauses(kByteTime);
    Duration now{};
    pauses.before(25, at(now), 0);
    pauses.frame_came(0, 25);
    for (int i = 0; i < 4; ++i) {
        pauses.before(10, at(now + 14ms), 0);
        pauses.before(15, at(now + 214ms), 10);
        now += 214ms;
    }
    EXPECT_TRUE(pauses.before(25, at(now + 14ms), 0));
}

}  // namespace
}  // namespace tribus::line_pauses_test
