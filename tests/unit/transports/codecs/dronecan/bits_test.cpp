#include <array>
#include <cstdint>

#include <gtest/gtest.h>

#include "transports/codecs/dronecan/bits.h"

namespace tribus::dronecan::bits_test {
namespace {

/// The worked example of the specification, "Byte order and bit order": 0xbeda in 12 bits, -1 in 3,
/// -5 in 4, -1 in 2, 0x88 in 4. Its figure: 11011010 11101111 01111100 00000000.
TEST(DroneCanBits, AreWrittenAsTheSpecificationDrawsThem) {
    std::array<std::uint8_t, 4> bytes{};
    BitWriter writer(bytes);
    writer.put(0xBEDA, 12);
    writer.put(0x7, 3);
    writer.put(0xB, 4);
    writer.put(0x3, 2);
    writer.put(0x8, 4);
    EXPECT_EQ(bytes, (std::array<std::uint8_t, 4>{0xDA, 0xEF, 0x7C, 0x00}));
    EXPECT_EQ(writer.bytes_put(), 4U);
}

TEST(DroneCanBits, AValueOfAnyLengthAnywhereIsReadAsItWasWritten) {
    for (unsigned before = 0; before <= 16; ++before) {
        for (unsigned bits = 0; bits <= 64; ++bits) {
            const std::uint64_t value = bits == 0 ? 0 : 0xA5C396F00F69D2B7U >> (64U - bits);
            std::array<std::uint8_t, 11> bytes{};
            BitWriter writer(bytes);
            writer.put(0xFFFF, before);
            writer.put(value, bits);
            writer.put(0x5, 3);
            BitReader reader(bytes);
            EXPECT_EQ(reader.take(before), 0xFFFFU & ((1U << before) - 1));
            EXPECT_EQ(reader.take(bits), value) << before << "+" << bits;
            EXPECT_EQ(reader.take(3), 0x5U);
            EXPECT_EQ(reader.left(), 88 - before - bits - 3);
            EXPECT_FALSE(reader.refused());
        }
    }
}

TEST(DroneCanBits, BeyondTheEndThereIsNothingAndItIsToldToTheEnd) {
    const std::array<std::uint8_t, 1> bytes{0xFF};
    BitReader reader(bytes);
    EXPECT_EQ(reader.take(4), 0xFU);
    EXPECT_EQ(reader.take(5), 0U);
    EXPECT_TRUE(reader.refused());
    EXPECT_EQ(reader.take(1), 0U);
    EXPECT_EQ(reader.left(), 0U);
    EXPECT_TRUE(reader.refused());
}

}  // namespace
}  // namespace tribus::dronecan::bits_test
