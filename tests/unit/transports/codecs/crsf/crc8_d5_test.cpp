#include "transports/codecs/crc8_d5.h"

#include <array>
#include <cstdint>
#include <random>
#include <span>

#include <gtest/gtest.h>

namespace tribus::test::crc8_d5_test {
namespace {

using Folded = std::array<std::uint8_t, kCrc8D5FoldedBytes>;

/// The remainder of all bytes, bit by bit.
std::uint8_t plain_remainder(std::span<const std::uint8_t> bytes) {
    constexpr unsigned kPolynomial = 0x1D5;
    unsigned rest = 0;
    for (const std::uint8_t byte : bytes) {
        for (unsigned bit = 8; bit-- > 0;) {
            rest = rest << 1U | (byte >> bit & 1U);
            rest ^= (rest & 0x100U) != 0 ? kPolynomial : 0;
        }
    }
    return static_cast<std::uint8_t>(rest);
}

// CRC-8/DVB-S2 of the catalogue.
TEST(Crc8D5, HasTheCheckValueOfTheCatalogue) {
    constexpr std::array<std::uint8_t, 9> kDigits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    EXPECT_EQ(Crc8D5::of(0, std::span<const std::uint8_t>(kDigits)), 0xBC);
}

// A CRC with start 0 is linear, so the single bits stand for all values.
TEST(Crc8D5, TheRemainderOf24BytesIsThatOfThePlainFormForEachBit) {
    for (std::size_t bit = 0; bit < 8 * kCrc8D5FoldedBytes; ++bit) {
        Folded bytes{};
        bytes[bit / 8] = static_cast<std::uint8_t>(1U << bit % 8);
        EXPECT_EQ(crc8_d5_remainder(bytes), plain_remainder(bytes)) << "bit " << bit;
    }
}

TEST(Crc8D5, TheRemainderOf24BytesIsThatOfThePlainFormForRandomBytes) {
    std::mt19937 random(1);
    for (int round = 0; round < 10'000; ++round) {
        Folded bytes{};
        for (std::uint8_t& byte : bytes) {
            byte = static_cast<std::uint8_t>(random());
        }
        ASSERT_EQ(crc8_d5_remainder(bytes), plain_remainder(bytes)) << "round " << round;
    }
}

TEST(Crc8D5, TheRemainderWith0AtTheEndIsTheCrcAndWithTheCrcIs0) {
    Folded bytes{0x16, 0xE0, 0x03, 0x1F};
    const std::uint8_t crc = crc8_d5_remainder(bytes);
    EXPECT_EQ(crc, Crc8D5::of(0, std::span<const std::uint8_t>(bytes).first<23>()));
    bytes.back() = crc;
    EXPECT_EQ(crc8_d5_remainder(bytes), 0);
}

}  // namespace
}  // namespace tribus::test::crc8_d5_test
