#include "app/wire/frames/waveform.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>

#include <gtest/gtest.h>

namespace tribus::waveform_test {
namespace {

using namespace std::chrono_literals;

constexpr LineSettings kIbusLine{.baud = 115200, .parity = Parity::none, .stop_bits = 1};
constexpr LineSettings kSbusLine{
    .baud = 100000, .parity = Parity::even, .stop_bits = 2, .inverted_wire = true};

/// Returns the dump after its `#0` line.
std::string drawn(const LineSettings& line, Duration start, std::span<const std::uint8_t> bytes) {
    Waveform waveform(line);
    std::string dump;
    waveform.begin(dump, start);
    waveform.frame(dump, start, bytes);
    waveform.end(dump);
    return dump.substr(dump.find("#0\n") + 3);
}

TEST(Waveform, StatesItsTimescaleAndItsSignal) {
    std::string dump;
    Waveform(kIbusLine).begin(dump, 1ms);
    EXPECT_EQ(dump,
              "$timescale 10 ns $end\n$scope module tribus $end\n$var wire 1 ! wire $end\n"
              "$upscope $end\n$enddefinitions $end\n#0\n1!\n");
}

// 0x0F at 100000 baud: start, 1111 0000, even parity 0, stop. One bit is 10 us or 1000 units.
TEST(Waveform, SbusIdlesLowAndItsStartBitIsHigh) {
    EXPECT_EQ(drawn(kSbusLine, 1ms, std::array<std::uint8_t, 1>{0x0F}),
              "0!\n#100000\n1!\n#101000\n0!\n#105000\n1!\n#110000\n0!\n#124000\n");
}

// 0x01 has an odd number of ones, so the parity bit is a one, like the stop bits after it.
TEST(Waveform, ParityBitMakesTheOnesEven) {
    EXPECT_EQ(drawn(kSbusLine, 1ms, std::array<std::uint8_t, 1>{0x01}),
              "0!\n#100000\n1!\n#101000\n0!\n#102000\n1!\n#109000\n0!\n#124000\n");
}

// Two bytes of 0x55 at 115200 baud without parity change the level at each of the 20 bits. Bit 17
// starts 147.57 us after the first bit, not at 17 times a rounded 8.68 us.
TEST(Waveform, EdgesStandAtTrueBitTimes) {
    const std::string dump = drawn(kIbusLine, 1ms, std::array<std::uint8_t, 2>{0x55, 0x55});
    EXPECT_NE(dump.find("1!\n#100000\n0!\n#100868\n1!\n#101736\n0!\n"), std::string::npos);
    EXPECT_NE(dump.find("#114757\n1!\n"), std::string::npos);
}

// Start, eight data bits, parity, two stop bits: the second start bit comes 12 bits later.
TEST(Waveform, TwoStopBitsStandBetweenSbusBytes) {
    const std::string dump = drawn(kSbusLine, 1ms, std::array<std::uint8_t, 2>{0x0F, 0x0F});
    EXPECT_NE(dump.find("#110000\n0!\n#112000\n1!\n"), std::string::npos) << dump;
}

TEST(Waveform, FrameAtTimeZeroIsMovedSoThatTheWireIdlesFirst) {
    const std::string dump = drawn(kSbusLine, 0us, std::array<std::uint8_t, 1>{0x0F});
    EXPECT_EQ(dump.substr(0, 12), "0!\n#12000\n1!");
}

TEST(Waveform, FrameWaitsUntilTheOneAheadHasLeft) {
    Waveform waveform(kSbusLine);
    std::string dump;
    waveform.begin(dump, 1ms);
    waveform.frame(dump, 1ms, std::array<std::uint8_t, 2>{0x0F, 0x00});
    dump.clear();
    waveform.frame(dump, 1100us, std::array<std::uint8_t, 1>{0x0F});
    EXPECT_EQ(dump.substr(0, 11), "#124000\n1!\n");
    EXPECT_EQ(waveform.delayed(), 1U);
}

TEST(Waveform, RoundedStartBehindAFrameIsNoDelay) {
    Waveform waveform(kIbusLine);
    std::string dump;
    waveform.begin(dump, 1ms);
    waveform.frame(dump, 1ms, std::array<std::uint8_t, 2>{0x20, 0x40});
    waveform.frame(dump, 1173us, std::array<std::uint8_t, 1>{0x20});
    EXPECT_EQ(waveform.delayed(), 0U);
}

}  // namespace
}  // namespace tribus::waveform_test
