#include "transports/codecs/read_times.h"

#include <gtest/gtest.h>

namespace tribus::read_times_test {
namespace {

using namespace std::chrono_literals;

TEST(ReadTimes, TellsOfEachByteTheReadThatBroughtIt) {
    ReadTimes times;
    times.add(3, Instant(10ms));
    times.add(4, Instant(20ms));
    times.add(9, Instant(30ms));
    EXPECT_EQ(times.of(0), Instant(10ms));
    EXPECT_EQ(times.of(2), Instant(10ms));
    EXPECT_EQ(times.of(3), Instant(20ms));
    EXPECT_EQ(times.of(4), Instant(30ms));
    EXPECT_EQ(times.of(8), Instant(30ms));
}

TEST(ReadTimes, AReadWithoutBytesMakesNothingYounger) {
    ReadTimes times;
    times.add(25, Instant(10ms));
    for (std::size_t read = 0; read < 2 * LineBuffer::kCapacity; ++read) {
        times.add(25, Instant(90ms));
    }
    EXPECT_EQ(times.of(24), Instant(10ms));
}

TEST(ReadTimes, KnowsAllThatADecoderCanHoldThoughEachByteCameAlone) {
    ReadTimes times;
    constexpr std::uint64_t kBytes = 1000;
    for (std::uint64_t end = 1; end <= kBytes; ++end) {
        times.add(end, Instant(1ms * end));
        const std::uint64_t oldest = end > LineBuffer::kCapacity ? end - LineBuffer::kCapacity : 0;
        for (std::uint64_t position = oldest; position < end; ++position) {
            ASSERT_EQ(times.of(position), Instant(1ms * (position + 1)));
        }
    }
}

TEST(ReadTimes, OneLongReadIsOneTime) {
    ReadTimes times;
    times.add(5, Instant(1ms));
    times.add(4000, Instant(2ms));
    EXPECT_EQ(times.of(5), Instant(2ms));
    EXPECT_EQ(times.of(3999), Instant(2ms));
}

}  // namespace
}  // namespace tribus::read_times_test
