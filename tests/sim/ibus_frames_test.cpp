#include "tests/sim/ibus_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// The simulation hides no more damage than a reader cannot see.
namespace tribus::test::ibus_frames_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// The line of random world 4007427 lost 74 33 of this frame and added 34 73.
const Bytes kSent{0x20, 0x40, 0xad, 0xb7, 0xe8, 0x13, 0xdb, 0x76, 0x7c, 0x84, 0xb9,
                  0x54, 0xf6, 0x74, 0x33, 0x05, 0x70, 0xd5, 0xad, 0x75, 0xea, 0x85,
                  0x27, 0xe6, 0x64, 0x36, 0xa1, 0x06, 0xde, 0x06, 0x38, 0xf1};
const Bytes kOfTheSameSum{0x20, 0x40, 0xad, 0xb7, 0xe8, 0x13, 0xdb, 0x76, 0x7c, 0x84, 0x34,
                          0x73, 0xb9, 0x54, 0xf6, 0x05, 0x70, 0xd5, 0xad, 0x75, 0xea, 0x85,
                          0x27, 0xe6, 0x64, 0x36, 0xa1, 0x06, 0xde, 0x06, 0x38, 0xf1};

TEST(HiddenDamage, IsAnotherFrameWithTheRightSumAndValuesOfSticks) {
    EXPECT_TRUE(damage_is_hidden(kOfTheSameSum, kSent));
}

TEST(HiddenDamage, IsFoundBehindNoise) {
    Bytes received{0x11, 0x20};
    received.insert(received.end(), kOfTheSameSum.begin(), kOfTheSameSum.end());
    EXPECT_TRUE(damage_is_hidden(received, kSent));
}

TEST(HiddenDamage, IsNotInAFrameThatWasSent) {
    Bytes received{0x11, 0x20};
    received.insert(received.end(), kSent.begin(), kSent.end());
    EXPECT_FALSE(damage_is_hidden(received, kSent));
}

TEST(HiddenDamage, ShowsInAnyOtherSum) {
    for (std::size_t at = 0; at < kSent.size(); ++at) {
        Bytes received = kOfTheSameSum;
        received[at] ^= 0x01;
        EXPECT_FALSE(damage_is_hidden(received, kSent)) << at;
    }
}

TEST(HiddenDamage, ShowsInValuesThatNoStickHas) {
    Bytes received = kSent;  // 1965 and 1000 us become 173 and 2792 us, with the same sum
    received[3] = 0xb0;
    received[5] = 0x1a;
    EXPECT_FALSE(damage_is_hidden(received, kSent));
}

TEST(HiddenDamage, IsNotInAFrameThatLostBytes) {
    for (std::size_t count = 0; count < kSent.size(); ++count) {
        EXPECT_FALSE(damage_is_hidden(std::span(kOfTheSameSum).first(count), kSent)) << count;
    }
}

}  // namespace
}  // namespace tribus::test::ibus_frames_test
