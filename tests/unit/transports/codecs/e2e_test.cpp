#include "transports/codecs/e2e.h"

#include <gtest/gtest.h>

#include <array>
#include <string_view>

#include "tests/support/streams.h"

namespace tribus::e2e_test {
namespace {

using test::Bytes;
using test::from_hex;

Bytes text(std::string_view characters) {
    return {characters.begin(), characters.end()};
}

// The check values of the catalogue of CRC algorithms: the CRC of "123456789".
TEST(E2eCrc, HasTheCatalogueCheckValues) {
    const Bytes check = text("123456789");
    EXPECT_EQ(crc8_1d(0xFF, check) ^ 0xFF, 0x4B);  // CRC-8/SAE-J1850
    EXPECT_EQ(crc8_2f(0xFF, check) ^ 0xFF, 0xDF);  // CRC-8/AUTOSAR
    EXPECT_EQ(crc16_1021(0xFFFF, check), 0x29B1);  // CRC-16/CCITT-FALSE (IBM-3740)
}

TEST(E2eCrc, GoesOnWhereItStopped) {
    EXPECT_EQ(crc8_2f(crc8_2f(0xFF, text("1234")), text("56789")),
              crc8_2f(0xFF, text("123456789")));
    EXPECT_EQ(crc16_1021(crc16_1021(0xFFFF, text("1")), text("23456789")), 0x29B1);
}

// AUTOSAR PRS_E2EProtocol 6.3.5, data id 0x0123, counter 0 and 1.
TEST(E2eProfile1, GivesTheExamplesOfItsSpecification) {
    EXPECT_EQ(p01_crc(from_hex("0000000000000000"), 0x0123), 0xCC);
    EXPECT_EQ(p01_crc(from_hex("0001000000000000"), 0x0123), 0x91);
    EXPECT_EQ(p01_crc(from_hex("0000000000000000"), 0x0123, P01DataId::alternating), 0xCE);
    EXPECT_EQ(p01_crc(from_hex("0001000000000000"), 0x0123, P01DataId::alternating), 0x02);
    EXPECT_EQ(p01_crc(from_hex("0000000000000000"), 0x0123, P01DataId::low), 0xCE);
    EXPECT_EQ(p01_crc(from_hex("0001000000000000"), 0x0123, P01DataId::low), 0x93);
    EXPECT_EQ(p01_crc(from_hex("0010000000000000"), 0x0123, P01DataId::nibble), 0x2A);
    EXPECT_EQ(p01_crc(from_hex("0011000000000000"), 0x0123, P01DataId::nibble), 0x77);
}

// e2e_vectors.json: data id list 01 to 10, so counter 1 has id 02 and counter 2 id 03.
TEST(E2eProfile22, GivesTheExamplesOfItsSpecification) {
    EXPECT_EQ(p22_crc(from_hex("0001000000000000"), 0x02), 0x1B);
    EXPECT_EQ(p22_crc(from_hex("0002000000000000"), 0x03), 0x98);
}

// AUTOSAR PRS_E2EProtocol, tables 6.27 and 6.28, data id 0x1234.
TEST(E2eProfile5, GivesTheExamplesOfItsSpecification) {
    EXPECT_EQ(p05_crc(from_hex("0000000000000000"), 0x1234), 0xCA1C);
    EXPECT_EQ(p05_crc(from_hex("00000000000000000000000000000000"), 0x1234, 8), 0x9128);
}

TEST(E2e, TheCrcsOwnBytesDoNotCount) {
    EXPECT_EQ(p01_crc(from_hex("AB01000000000000"), 0x0123), 0x91);
    EXPECT_EQ(p22_crc(from_hex("AB01000000000000"), 0x02), 0x1B);
    EXPECT_EQ(p05_crc(from_hex("ABCD000000000000"), 0x1234), 0xCA1C);
}

// docs/protocols/can.md, "End-to-end protection": 0x2F has Hamming distance 4 up to 127 bits.
TEST(E2eProfile22, SeesEveryErrorOfOneToThreeBits) {
    const Bytes sent = from_hex("BC859057B959F898");
    const auto holds = [](const Bytes& payload) { return p22_crc(payload, 0x05) == payload[0]; };
    ASSERT_TRUE(holds(sent));
    Bytes payload = sent;
    const auto flip = [&](std::size_t bit) {
        payload[bit / 8] = static_cast<std::uint8_t>(payload[bit / 8] ^ (1U << bit % 8));
    };
    for (std::size_t first = 0; first < 64; ++first) {
        flip(first);
        EXPECT_FALSE(holds(payload)) << first;
        for (std::size_t second = first + 1; second < 64; ++second) {
            flip(second);
            EXPECT_FALSE(holds(payload)) << first << ", " << second;
            for (std::size_t third = second + 1; third < 64; ++third) {
                flip(third);
                EXPECT_FALSE(holds(payload)) << first << ", " << second << ", " << third;
                flip(third);
            }
            flip(second);
        }
        flip(first);
    }
}

}  // namespace
}  // namespace tribus::e2e_test
