#include "pipelines/engine/read_pacer.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace tribus::read_pacer_test {
namespace {

using namespace std::chrono_literals;

/// i.Bus at 115200 baud: 86.8 us a byte, 32 bytes every 7.7 ms (docs/protocols/ibus.md, "Period and
/// gaps").
constexpr Duration kByteTime = 86'806ns;
constexpr int kLength = 32;
constexpr Duration kPeriod = 7700us;

/// A port on which frames arrive in pieces, read by a loop that follows the pacer.
struct Wire {
    ReadPacer pacer{kByteTime};
    Instant frame_start{1s};

    struct FrameReads {
        int reads = 0;
        Duration read_after_its_end{};
    };

    /// `piece` is the number of bytes that the driver delivers at once.
    FrameReads frame(int length = kLength, int piece = 1) {
        FrameReads result;
        int read = 0;
        Instant read_next = frame_start;
        for (int there = piece; there <= length; there += piece) {
            const Instant now = frame_start + there * kByteTime;
            const bool last = there + piece > length;
            if (now < read_next && !last) {
                continue;
            }
            const Instant reads_at = std::max(now, read_next);
            read_next = pacer.delivered(static_cast<std::size_t>(there - read), last, reads_at);
            read = there;
            ++result.reads;
            if (last) {
                result.read_after_its_end = reads_at - now;
            }
        }
        frame_start += kPeriod;
        return result;
    }
    void frames(int count, int length = kLength, int piece = 1) {
        for (int i = 0; i < count; ++i) {
            frame(length, piece);
        }
    }
};

TEST(ReadPacer, ReadsEveryByteUntilItHasSeenNineWholeFramesByteByByte) {
    Wire wire;
    for (int i = 0; i < 9; ++i) {
        EXPECT_EQ(wire.frame().reads, kLength) << i;
    }
}

TEST(ReadPacer, ThenReadsTheFirstByteAndTheLastOnes) {
    Wire wire;
    wire.frames(9);
    for (int i = 0; i < 100; ++i) {
        const auto frame = wire.frame();
        EXPECT_LE(frame.reads, 4) << i;
        EXPECT_EQ(frame.read_after_its_end, 0ns) << i;
    }
}

TEST(ReadPacer, LeavesAPortAloneThatDeliversFramesInFewPieces) {
    Wire wire;
    for (int i = 0; i < 30; ++i) {
        EXPECT_EQ(wire.frame(kLength, 8).reads, 4);
    }
    Wire whole;
    for (int i = 0; i < 30; ++i) {
        EXPECT_EQ(whole.frame(kLength, kLength).reads, 1);
    }
}

TEST(ReadPacer, StopsWhenThePortBeginsToDeliverInLargePieces) {
    Wire wire;
    wire.frames(20);
    wire.frame(kLength, 16);
    EXPECT_EQ(wire.frame().reads, kLength);
}

TEST(ReadPacer, AFrameOfAnotherLengthMakesItLookAgainAtEveryByte) {
    Wire wire;
    wire.frames(20);
    wire.frame(40);
    EXPECT_EQ(wire.frame(40).reads, 40);
    wire.frames(8, 40);
    EXPECT_LE(wire.frame(40).reads, 4);
}

TEST(ReadPacer, WithoutAPauseBeforeItTheFirstByteMayBeAnyByte) {
    Wire wire;
    wire.frames(20);
    const Instant in_the_middle = wire.frame_start;
    wire.pacer.delivered(5, true, in_the_middle);
    wire.pacer.delivered(32, true, in_the_middle);
    EXPECT_EQ(wire.pacer.delivered(1, false, in_the_middle + kByteTime), in_the_middle + kByteTime);
}

TEST(ReadPacer, NeverWaitsOnAPortWithoutAWire) {
    ReadPacer pacer{0ns};
    Instant now{1s};
    for (int frame = 0; frame < 50; ++frame) {
        for (int byte = 0; byte < kLength; ++byte, now += kByteTime) {
            EXPECT_EQ(pacer.delivered(1, byte == kLength - 1, now), now);
        }
        now += 5ms;
    }
}

TEST(ReadPacer, NeverWaitsLongerThanAFrameTakes) {
    Wire wire;
    wire.frames(20);
    const Instant first = wire.frame_start + kByteTime;
    const Instant next = wire.pacer.delivered(1, false, first);
    EXPECT_GT(next, first);
    EXPECT_LE(next, wire.frame_start + (kLength - 1) * kByteTime);
}

}  // namespace
}  // namespace tribus::read_pacer_test
