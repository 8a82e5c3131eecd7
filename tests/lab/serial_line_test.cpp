#include <chrono>
#include <memory>
#include <numeric>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/program.h"
#include "transports/links/serial/serial_port.h"

/// Line settings on real drivers, which a pty cannot show.
namespace tribus::test::serial_line_test {
namespace {

constexpr LineSettings kSbusFast{.baud = 200'000, .parity = Parity::even, .stop_bits = 2};

std::unique_ptr<SerialPort> opened(const std::string& device, const LineSettings& settings) {
    auto port = SerialPort::open(device, settings);
    EXPECT_TRUE(port) << port.error();
    return port ? std::move(*port) : nullptr;
}

std::string refusal(const std::string& device, const LineSettings& settings) {
    const auto port = SerialPort::open(device, settings);
    EXPECT_FALSE(port) << "opened";
    return port ? "" : port.error();
}

Bytes all_byte_values() {
    Bytes bytes(256);
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
    return bytes;
}

Bytes receive(SerialPort& port, std::size_t count) {
    Bytes all;
    Reception reception;
    eventually([&] {
        if (port.read(reception) == ReadStatus::received) {
            EXPECT_TRUE(reception.damaged.none());
            const auto bytes = reception.view();
            all.insert(all.end(), bytes.begin(), bytes.end());
        }
        return all.size() >= count;
    });
    return all;
}

/// Bytes from the previous test may still be on their way through the emulator.
void wait_for_silence(SerialPort& port, Uart& far_end) {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::milliseconds kSilence{300};
    Reception reception;
    for (auto latest = Clock::now(); Clock::now() - latest < kSilence;) {
        if (port.read(reception) == ReadStatus::received || !far_end.receive().empty()) {
            latest = Clock::now();
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

TEST(LabFtdi, KeepsTheLineSettingsOfSbus) {
    const ProgrammedLines lines;
    const auto port = opened(ftdi_adapter(1), kSbus);
    ASSERT_TRUE(port);
    const LineSeen seen = line_of(port->descriptor());
    EXPECT_EQ(seen.baud, 100'000U);
    EXPECT_TRUE(seen.parity && seen.two_stop_bits && seen.eight_data_bits);
    lines.expect("parity E, data bits 8, stop bits 2");
    lines.expect("baud rate 100000");
}

TEST(LabFtdi, KeepsTheLineSettingsOfFastSbus) {
    const ProgrammedLines lines;
    const auto port = opened(ftdi_adapter(1), kSbusFast);
    ASSERT_TRUE(port);
    EXPECT_EQ(line_of(port->descriptor()).baud, 200'000U);
    lines.expect("parity E, data bits 8, stop bits 2");
    lines.expect("baud rate 200000");
}

TEST(LabFtdi, KeepsTheLineSettingsOfIbus) {
    const ProgrammedLines lines;
    const auto port = opened(ftdi_adapter(1), kIbus);
    ASSERT_TRUE(port);
    const LineSeen seen = line_of(port->descriptor());
    EXPECT_EQ(seen.baud, 115'200U);
    EXPECT_FALSE(seen.parity || seen.two_stop_bits);
    lines.expect("parity N, data bits 8, stop bits 1");
    // The nearest rate of the adapter: 3 MHz divided by 26.
    lines.expect("baud rate 115384");
}

TEST(LabFtdi, HandsOverBytesAsSoonAsTheyArrive) {
    const std::string device = ftdi_adapter(1);
    const auto port = opened(device, kSbus);
    // An FTDI's default is 16 ms, more than two SBUS frames.
    EXPECT_EQ(read_file("/sys/bus/usb-serial/devices/" + device.substr(5) + "/latency_timer"), "1");
}

TEST(LabFtdi, CarriesEveryByteValueBothWays) {
    const auto port = opened(ftdi_adapter(1), kSbus);
    ASSERT_TRUE(port);
    Uart far_end(ftdi_adapter(2), kSbus);
    const Bytes bytes = all_byte_values();
    far_end.send(bytes);
    EXPECT_EQ(receive(*port, bytes.size()), bytes);
    ASSERT_EQ(port->write(bytes), WriteStatus::written);
    EXPECT_EQ(far_end.receive(bytes.size()), bytes);
}

TEST(LabFtdi, ThatIsUnpluggedIsLostAndCanBeOpenedAgain) {
    const auto port = opened(ftdi_adapter(1), kSbus);
    ASSERT_TRUE(port);
    unplug_usb(1);
    Reception reception;
    EXPECT_TRUE(eventually([&] { return port->read(reception) == ReadStatus::lost; }));
    EXPECT_EQ(port->write(Bytes{1}), WriteStatus::lost);
    plug_usb(1);
    const ProgrammedLines lines;
    const auto again = opened(ftdi_adapter(1), kSbus);
    ASSERT_TRUE(again);
    lines.expect("parity E, data bits 8, stop bits 2");
    Uart far_end(ftdi_adapter(2), kSbus);
    far_end.send(Bytes{0x0F});
    EXPECT_EQ(receive(*again, 1), Bytes{0x0F});
}

TEST(LabFtdi, ThatIsInUseIsRefused) {
    const std::string device = ftdi_adapter(1);
    const auto port = opened(device, kSbus);
    const std::string why = refusal(device, kSbus);
    EXPECT_TRUE(why.starts_with(device + ": another program uses it")) << why;
}

TEST(Lab16550, ThatCannotDo100000BaudIsRefusedWithTheRateThatItWouldRunAt) {
    const std::string device = uart_16550(1);
    const std::string why = refusal(device, kSbus);
    // The driver reports 100000 and programs divisor 1 of 1.8432 MHz / 16 (docs/protocols/sbus.md,
    // "Serial port: bit rate").
    EXPECT_TRUE(why.starts_with(device + ": asked for 100000 baud, but the port runs at 115200"))
        << why;
    EXPECT_NE(why.find("divides 115200 baud by whole numbers"), std::string::npos) << why;
    EXPECT_NE(why.find("use a port that can: a USB adapter with an FTDI"), std::string::npos)
        << why;
}

TEST(Lab16550, ThatCannotDo200000BaudIsRefusedToo) {
    const std::string why = refusal(uart_16550(1), kSbusFast);
    EXPECT_NE(why.find("asked for 200000 baud, but the port runs at 115200"), std::string::npos)
        << why;
    EXPECT_NE(why.find("cannot go faster"), std::string::npos) << why;
}

TEST(Lab16550, KeepsTheLineSettingsOfIbus) {
    const ProgrammedLines lines;
    const auto port = opened(uart_16550(1), kIbus);
    ASSERT_TRUE(port);
    EXPECT_EQ(line_of(port->descriptor()).baud, 115'200U);
    lines.expect("baudrate=115200 parity='N' data=8 stop=1");
}

TEST(Lab16550, CarriesEveryByteValueBothWaysEvenAfterARefusal) {
    const std::string device = uart_16550(1);
    refusal(device, kSbus);
    const auto port = opened(device, kIbus);
    ASSERT_TRUE(port);
    Uart far_end(uart_16550(2), kIbus);
    wait_for_silence(*port, far_end);
    const Bytes bytes = all_byte_values();
    far_end.send(bytes);
    EXPECT_EQ(receive(*port, bytes.size()), bytes);
    ASSERT_EQ(port->write(bytes), WriteStatus::written);
    EXPECT_EQ(far_end.receive(bytes.size()), bytes);
}

}  // namespace
}  // namespace tribus::test::serial_line_test
