#include "transports/links/spi/uart_waveform.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_uart.h"
#include "tests/support/spi_controller.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/links/spi/spi_clock.h"

/// An independent UART reads what the data line of an SPI port draws.
namespace tribus::uart_waveform_test {
namespace {

using test::DrawnLine;
using test::PlainUart;
using test::SpiController;
using test::UartByte;

using Bytes = std::vector<std::uint8_t>;

constexpr LineSettings kSbusLine{
    .baud = 100000, .parity = Parity::even, .stop_bits = 2, .inverted_wire = true};

Bytes drawn(std::span<const std::uint8_t> bytes, const LineSettings& line = kSbusLine) {
    SpiWaveform waveform;
    EXPECT_TRUE(draw_uart(bytes, line, waveform));
    return {waveform.bits.begin(),
            waveform.bits.begin() + static_cast<std::ptrdiff_t>(waveform.bytes)};
}

/// 0x0F with even parity and two stop bits, inverted (docs/protocols/sbus.md, "Line").
TEST(UartWaveform, HasABitOfTheLineInEachByteOfThePort) {
    EXPECT_EQ(drawn(Bytes{0x0F}), (Bytes{0x00, 0x00,                 // at rest
                                         0xFF,                       // start
                                         0x00, 0x00, 0x00, 0x00,     // 1 1 1 1
                                         0xFF, 0xFF, 0xFF, 0xFF,     // 0 0 0 0
                                         0xFF,                       // even parity
                                         0x00, 0x00, 0x00, 0x00}));  // stop, at rest
}

TEST(UartWaveform, IsTheOppositeWhereTheLineIsNotInverted) {
    LineSettings plain = kSbusLine;
    plain.inverted_wire = false;
    Bytes opposite = drawn(Bytes{0x0F, 0xA5});
    std::ranges::transform(opposite, opposite.begin(),
                           [](std::uint8_t byte) { return static_cast<std::uint8_t>(~byte); });
    EXPECT_EQ(drawn(Bytes{0x0F, 0xA5}, plain), opposite);
}

TEST(UartWaveform, HasNoParityAndOneStopBitWhereTheLineHasNone) {
    const LineSettings line{.baud = 115200, .inverted_wire = true};
    EXPECT_EQ(drawn(Bytes{0x00}, line).size(), 4U + 10U);
    EXPECT_EQ(drawn(Bytes{0x00, 0xFF}, line).size(), 4U + 20U);
}

TEST(UartWaveform, IsNotDrawnWithoutBytesOrWithoutRoom) {
    SpiWaveform waveform;
    EXPECT_FALSE(draw_uart({}, kSbusLine, waveform));
    EXPECT_TRUE(draw_uart(Bytes(341), kSbusLine, waveform));
    EXPECT_EQ(waveform.bytes, 4096U);
    EXPECT_FALSE(draw_uart(Bytes(342), kSbusLine, waveform));
}

/// An SBUS frame of random values.
Bytes random_frame(std::mt19937& random) {
    SbusFrame frame;
    for (auto& raw : frame.raw) {
        raw = static_cast<std::uint16_t>(random() % 2048);
    }
    Bytes bytes(kSbusFrameLength);
    emit_sbus(frame, std::span(bytes).first<kSbusFrameLength>());
    bytes[23] = static_cast<std::uint8_t>(random() % 16);
    return bytes;
}

/// Whether it read exactly these bytes, without an error.
bool is_frame(const std::vector<UartByte>& read, const Bytes& frame) {
    return std::ranges::equal(read, frame, [](const UartByte& byte, std::uint8_t value) {
        return byte.value == value && !byte.parity_error && !byte.framing_error;
    });
}

struct Port {
    const char* name;
    SpiController controller;
};

class DrawnByAPort : public testing::TestWithParam<Port> {
  protected:
    SpiController controller_ = GetParam().controller;
    std::uint32_t asked_hz_ = [this] {
        const auto found =
            find_spi_rate(kSbusLine.bits_time(1), [this](std::uint32_t hz, std::size_t bytes) {
                return controller_.transfer_time(hz, bytes);
            });
        EXPECT_TRUE(found) << found.error();
        return found.value_or(800'000);
    }();
};

/// UARTs whose clocks are off by as much as cheap ones are.
TEST_P(DrawnByAPort, EachFrameIsReadAsItIs) {
    constexpr int kFrames = 10'000;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> rate_error(-0.02, 0.02);
    for (int i = 0; i < kFrames; ++i) {
        const Bytes frame = random_frame(random);
        const Bytes bits = drawn(frame);
        const DrawnLine line(controller_, asked_hz_, bits);
        const PlainUart uart{.rate_error = rate_error(random)};
        const auto read =
            uart.read([&](double us) { return line.level(us); }, -100, line.end_us() + 200);
        ASSERT_TRUE(is_frame(read, frame)) << GetParam().name << ", frame " << i << ", UART "
                                           << uart.rate_error << ", " << read.size() << " bytes";
    }
}

INSTANTIATE_TEST_SUITE_P(
    Ports, DrawnByAPort,
    testing::Values(Port{"8 clocks", {}}, Port{"9 clocks", {.clocks_a_byte = 9}},
                    Port{"8.25 clocks", {.clocks_a_byte = 8.25}},
                    Port{"a core of 500 MHz", {.core_hz = 500e6, .clocks_a_byte = 9}},
                    Port{"any divider of 48 MHz", {.core_hz = 48e6, .even_divider = false}},
                    Port{"a gap behind each 96 bytes",
                         {.bytes_a_burst = 96, .clocks_between_bursts = 2}},
                    Port{"a busy processor", {.clocks_a_byte = 9, .held_up_us = 80}}),
    [](const auto& param) {
        std::string name = param.param.name;
        std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
        return name;
    });

}  // namespace
}  // namespace tribus::uart_waveform_test
