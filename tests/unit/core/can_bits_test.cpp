#include "tests/support/can_bits.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "core/can_frame.h"

namespace tribus::test::can_bits_test {
namespace {

CanFrame frame_of(std::uint32_t id, std::uint8_t length, bool extended, bool fd = false) {
    return {.id = id, .extended = extended, .fd = fd, .bit_rate_switch = fd, .length = length};
}

/// docs/protocols/can.md, "Bits of a frame": 55 + 10 n with an 11-bit id, 80 + 10 n with a 29-bit
/// id, intermission included.
TEST(CanBits, AtMostAreThoseOfTheFormulasForEveryClassicLength) {
    for (std::uint8_t length = 0; length <= 8; ++length) {
        EXPECT_EQ(most_bits_on_bus(frame_of(0x123, length, false)),
                  (BusBits{.nominal = 55U + 10U * length}));
        EXPECT_EQ(most_bits_on_bus(frame_of(0x804742A, length, true)),
                  (BusBits{.nominal = 80U + 10U * length}));
    }
}

/// docs/protocols/can.md, "Bus load" and "Worst wait of a frame", at 500 kbit/s and 2 Mbit/s.
TEST(CanBits, AtMostTakeTheTimesOfTheTablesInFdFrames) {
    const auto microseconds = [](const CanFrame& frame) {
        const auto time = time_on_bus(most_bits_on_bus(frame), 500'000, 2'000'000);
        return std::chrono::ceil<std::chrono::microseconds>(time).count();
    };
    EXPECT_EQ(microseconds(frame_of(0x300, 48, false, true)), 327);
    EXPECT_EQ(microseconds(frame_of(0x804742A, 32, true, true)), 294);
    EXPECT_EQ(microseconds(frame_of(0x804742A, 64, true, true)), 454);
}

/// 34 zeros, 15 of them in the CRC: a stuff bit after every five.
TEST(CanBits, ClassicFrameOfZerosHasAStuffBitBehindEachFive) {
    EXPECT_EQ(bits_on_bus(frame_of(0, 0, false)), (BusBits{.nominal = 34 + 6 + 13}));
}

/// Start of frame and four zeros of the id: a one is stuffed. Four ones make five with it: a zero
/// is stuffed. Three zeros and RRS make five with it: a one is stuffed. Then IDE 0, FDF 1, res 0,
/// BRS 1.
TEST(CanBits, StuffBitBeginsTheNextRun) {
    EXPECT_EQ(bits_on_bus(frame_of(0b0000'1111'000, 0, false, true)).nominal, 17U + 3U + 13U);
}

/// ESI and a length code of 0 are five zeros after BRS. Only the stuff bit at the start of the CRC
/// field follows: 4 bits of stuff count and 17 bits of CRC with 6 stuff bits.
TEST(CanBits, NoSecondStuffBitStandsBetweenTheDataAndTheCrcOfAnFdFrame) {
    EXPECT_EQ(bits_on_bus(frame_of(0x555, 0, false, true)).data, 5U + 4U + 17U + 6U);
}

TEST(CanBits, CrcOfFdFramesIsLongerBeyond16Bytes) {
    const auto bits_at_most = [](std::uint8_t length) {
        return most_bits_on_bus(frame_of(0x555, length, false, true)).data;
    };
    // Four bytes, 8 stuff bits for them, 4 bits of CRC and a stuff bit in it.
    EXPECT_EQ(bits_at_most(20) - bits_at_most(16), 32U + 8U + 4U + 1U);
}

TEST(CanBits, FdFrameWithoutBitRateSwitchIsAllAtTheNominalRate) {
    CanFrame frame = frame_of(0x555, 8, false, true);
    const BusBits switched = most_bits_on_bus(frame);
    frame.bit_rate_switch = false;
    EXPECT_EQ(most_bits_on_bus(frame), (BusBits{.nominal = switched.nominal + switched.data}));
}

}  // namespace
}  // namespace tribus::test::can_bits_test
