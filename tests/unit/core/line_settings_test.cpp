#include "core/line_settings.h"

#include <gtest/gtest.h>

#include <chrono>

namespace tribus::line_settings_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr LineSettings kIbusLine{};
constexpr LineSettings kSbusLine{
    .baud = 100000, .parity = Parity::even, .stop_bits = 2, .inverted_wire = true};

TEST(LineSettings, DefaultIsTheLineOfIbus) {
    EXPECT_EQ(kIbusLine.baud, 115200U);
    EXPECT_EQ(kIbusLine.parity, Parity::none);
    EXPECT_EQ(kIbusLine.stop_bits, 1);
    EXPECT_FALSE(kIbusLine.inverted_wire);
}

TEST(LineSettings, CountsEveryBitOfAByte) {
    EXPECT_EQ(kIbusLine.bits_per_byte(), 10U);
    EXPECT_EQ(kSbusLine.bits_per_byte(), 12U);
    EXPECT_EQ((LineSettings{.stop_bits = 2}.bits_per_byte()), 11U);
    EXPECT_EQ((LineSettings{.parity = Parity::even}.bits_per_byte()), 11U);
}

// docs/protocols/sbus.md, "Line": 120 us a byte and 3.00 ms a frame, half as much at 200000 baud.
TEST(LineSettings, AnSbusFrameTakesThreeMilliseconds) {
    EXPECT_EQ(kSbusLine.bytes_time(1), microseconds(120));
    EXPECT_EQ(kSbusLine.bytes_time(25), milliseconds(3));
    LineSettings fast = kSbusLine;
    fast.baud = 200000;
    EXPECT_EQ(fast.bytes_time(25), microseconds(1500));
}

// 32 bytes of 10 bits at 115200: 2777.78 us.
TEST(LineSettings, RoundsToTheNearestNanosecond) {
    EXPECT_EQ(kIbusLine.bytes_time(32), Duration(2777778));
    EXPECT_EQ(kIbusLine.bits_time(1), Duration(8681));
    EXPECT_EQ(kIbusLine.bits_time(0), Duration(0));
}

TEST(LineSettings, TheWholeIsNotTheSumOfRoundedParts) {
    EXPECT_EQ(kIbusLine.bits_time(115200), std::chrono::seconds(1));
    EXPECT_EQ(kIbusLine.bits_time(115200ULL * 86400), std::chrono::hours(24));
}

TEST(LineSettings, DifferInAnyMember) {
    LineSettings other = kSbusLine;
    EXPECT_EQ(other, kSbusLine);
    other.inverted_wire = false;
    EXPECT_NE(other, kSbusLine);
}

TEST(Time, LaterAddsAndStopsAtNever) {
    const Instant noon(std::chrono::hours(12));
    EXPECT_EQ(later(noon, milliseconds(7)), noon + milliseconds(7));
    EXPECT_EQ(later(kNever, milliseconds(7)), kNever);
    EXPECT_EQ(later(noon, Duration::max()), kNever);
    EXPECT_EQ(later(Instant(milliseconds(-5)), milliseconds(7)), Instant(milliseconds(2)));
    EXPECT_EQ(later(Instant(milliseconds(-5)), Duration::max()),
              Instant(milliseconds(-5)) + Duration::max());
}

}  // namespace
}  // namespace tribus::line_settings_test
