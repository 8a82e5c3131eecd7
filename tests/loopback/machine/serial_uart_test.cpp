#include "transports/links/serial/serial_port.h"

#include <cerrno>
#include <chrono>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipelines/realtime/clock.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/uart_stand_in.h"

/// How a serial port opens and closes a UART, with a stand-in for its driver.
namespace tribus::test::serial_uart_test {
namespace {

using namespace std::chrono_literals;
using Requests = std::vector<unsigned long>;

constexpr const char* kHasNoDevice =
    "the device node exists, but it has no device; is the port enabled?";
constexpr const char* kNotSerial = "this is not a serial device; give one, such as /dev/ttyUSB0";

/// How often a request was made.
std::ptrdiff_t asked(const DeviceStandIn& device, unsigned long request) {
    return std::ranges::count(device.asked, request);
}

TEST_F(SerialUart, GetsTheLineOfSbus) {
    const Uart uart(device_);
    const auto port = opened();
    EXPECT_EQ(uart.set.c_iflag, static_cast<tcflag_t>(INPCK | PARMRK));
    EXPECT_EQ(uart.set.c_oflag, 0U);
    EXPECT_EQ(uart.set.c_cflag,
              static_cast<tcflag_t>(CS8 | CREAD | CLOCAL | BOTHER | PARENB | CSTOPB));
    EXPECT_EQ(uart.set.c_lflag, 0U);
    EXPECT_EQ(uart.set.c_ispeed, 100'000U);
    EXPECT_EQ(uart.set.c_ospeed, 100'000U);
    for (int i = 0; i < NCCS; ++i) {
        EXPECT_EQ(uart.set.c_cc[i], i == VMIN ? 1 : 0) << i;
    }
}

TEST_F(SerialUart, GetsTheLineOfIbus) {
    const Uart uart(device_);
    const auto port = opened(LineSettings{});
    EXPECT_EQ(uart.set.c_cflag, static_cast<tcflag_t>(CS8 | CREAD | CLOCAL | BOTHER));
    EXPECT_EQ(uart.set.c_ispeed, 115'200U);
}

TEST_F(SerialUart, IsClaimedThenSetThenEmptied) {
    const Uart uart(device_);
    const auto port = opened();
    EXPECT_EQ(uart.asked, (Requests{TIOCGEXCL, TIOCEXCL, TCSETS2, TCFLSH, TCGETS2, TIOCGSERIAL,
                                    TIOCGSERIAL, TIOCSSERIAL, TIOCSSERIAL}));
    EXPECT_EQ(uart.flushed, std::vector<int>{TCIOFLUSH});
    EXPECT_EQ(uart.exclusive, 1);
}

TEST_F(SerialUart, IsAskedForShortDelaysAndThenForAShortClose) {
    Uart uart(device_);
    uart.driver.flags = 0x40;
    uart.driver.closing_wait = 3000;
    const auto port = opened();
    ASSERT_EQ(uart.driver_settings.size(), 2U);
    EXPECT_EQ(uart.driver_settings[0].flags, 0x2040);
    EXPECT_EQ(uart.driver_settings[0].closing_wait, 3000);
    EXPECT_EQ(uart.driver_settings[1].flags, 0x2040);
    EXPECT_EQ(uart.driver_settings[1].closing_wait, 10);
}

TEST_F(SerialUart, OpensAlthoughItsDriverHasNoSettingsOfItsOwn) {
    Uart uart(device_);
    uart.driver.baud_base = 115'200;
    uart.driver_failure = ENOTTY;
    EXPECT_NE(opened(), nullptr) << "what is not told is not judged";
    EXPECT_TRUE(uart.driver_settings.empty());
}

TEST_F(SerialUart, OpensWhereItsDriverTellsNoBase) {
    Uart uart(device_);
    uart.driver.baud_base = 0;
    EXPECT_NE(opened(), nullptr);
}

TEST_F(SerialUart, IsRefusedWhereItsBaseCannotDoTheRate) {
    Uart uart(device_);
    uart.driver.baud_base = 115'200;
    EXPECT_TRUE(refusal().starts_with("asked for 100000 baud, but the port runs at 115200"));
}

struct Change {
    const char* name;
    tcflag_t cleared;
    tcflag_t set;
    const char* refusal;
};

class LineThatIsNotKept : public SerialUart, public ::testing::WithParamInterface<Change> {};

TEST_P(LineThatIsNotKept, IsRefused) {
    Uart uart(device_);
    uart.cleared_flags = GetParam().cleared;
    uart.set_flags = GetParam().set;
    EXPECT_TRUE(refusal().starts_with(GetParam().refusal)) << refusal();
    EXPECT_EQ(asked(uart, TIOCSSERIAL), 0);
}

constexpr const char* kDropsParity = "asked for even parity, but the port drops the parity bit";
INSTANTIATE_TEST_SUITE_P(
    Drivers, LineThatIsNotKept,
    ::testing::Values(
        Change{"Parity", PARENB, 0, kDropsParity}, Change{"OddParity", 0, PARODD, kDropsParity},
        Change{"StickParity", 0, CMSPAR, kDropsParity},
        Change{"StopBits", CSTOPB, 0, "asked for 2 stop bits, but the port does not keep that"},
        Change{"DataBits", 0x10, 0, "asked for 8 data bits, but the port does not keep that"}),
    [](const auto& change) { return std::string(change.param.name); });

TEST_F(SerialUart, SaysThatItsDeviceIsGone) {
    for (const int error : {EIO, ENXIO, ENODEV, EPIPE, EBADF}) {
        for (const unsigned long request :
             {static_cast<unsigned long>(TCSETS2), static_cast<unsigned long>(TCGETS2)}) {
            Uart uart(device_);
            uart.refused = {{request, error}};
            EXPECT_EQ(refusal(), kHasNoDevice) << error;
        }
    }
}

TEST_F(SerialUart, SaysWhatItsDriverRefuses) {
    for (const unsigned long request :
         {static_cast<unsigned long>(TCSETS2), static_cast<unsigned long>(TCGETS2)}) {
        Uart uart(device_);
        uart.refused = {{request, EINVAL}};
        EXPECT_EQ(refusal(), "its driver refuses the line settings: Invalid argument");
        uart.refused = {{request, ENOTTY}};
        EXPECT_EQ(refusal(), kNotSerial);
    }
}

TEST_F(SerialUart, SaysThatItsNodeCannotBeRead) {
    Uart uart(device_);
    uart.state_failure = EIO;
    EXPECT_EQ(refusal(), kHasNoDevice);
    EXPECT_TRUE(uart.asked.empty());
}

TEST_F(SerialUart, IsNotSharedEvenWithRoot) {
    Uart uart(device_);
    uart.exclusive = 1;
    EXPECT_TRUE(refusal().starts_with("another program uses it")) << refusal();
    EXPECT_EQ(asked(uart, TCSETS2), 0);
}

// The mark of a killed program stays as long as the other end is open.
TEST_F(SerialUart, ThatIsAPtyMayBeMarkedByAProgramThatIsGone) {
    Uart pty(device_, 136, 5);
    pty.exclusive = 1;
    EXPECT_NE(opened(), nullptr);
}

TEST(SerialUartOpen, ADeviceThatIsNoTerminalIsAskedForNothing) {
    const DeviceStandIn null("/dev/null");
    EXPECT_FALSE(SerialPort::open("/dev/null", kSbusLine8E2).has_value());
    EXPECT_EQ(null.opened, 1);
    EXPECT_TRUE(null.asked.empty());
}

TEST(SerialUartOpen, AFileIsNotEvenOpened) {
    const TemporaryFolder folder;
    const std::string path = folder.write("file", "");
    const DeviceStandIn file(path);
    EXPECT_FALSE(SerialPort::open(path, kSbusLine8E2).has_value());
    EXPECT_EQ(file.opened, 0);
}

TEST(SerialUartOpen, IsMissingWhereNothingHasThatName) {
    EXPECT_TRUE(SerialPort::is_missing("/dev/ttyNO0"));
    errno = ENOENT;
    EXPECT_FALSE(SerialPort::is_missing("/dev/null"));
    EXPECT_FALSE(SerialPort::is_missing("/dev/null/ttyNO0")) << "it can never be there";
}

/// The calls that a port makes at its end.
struct End {
    std::ptrdiff_t looks = 0;
    std::vector<int> flushed{};
    int exclusive = -1;

    bool operator==(const End&) const = default;
};

class EndOfASerialUart : public SerialUart {
  protected:
    End end_of(Uart& uart) {
        auto port = opened();
        uart.asked.clear();
        uart.flushed.clear();
        port.reset();
        return {asked(uart, TIOCOUTQ), uart.flushed, uart.exclusive};
    }
};

TEST_F(EndOfASerialUart, WaitsForNothingWhereNothingIsSent) {
    Uart uart(device_);
    EXPECT_EQ(end_of(uart), (End{1, {}, 0}));
}

TEST_F(EndOfASerialUart, WaitsUntilTheLastByteIsSent) {
    Uart uart(device_);
    uart.queue = {2, 1, 0};
    EXPECT_EQ(end_of(uart), (End{3, {}, 0}));
}

TEST_F(EndOfASerialUart, DiscardsWhatIsNotSentAfter20Milliseconds) {
    Uart uart(device_);
    uart.queue = {1};
    const Instant begin = monotonic_now();
    EXPECT_EQ(end_of(uart), (End{20, {TCOFLUSH}, 0}));
    EXPECT_GE(monotonic_now() - begin, 20ms);
}

TEST_F(EndOfASerialUart, DoesNotWaitForADriverThatGivesNoCount) {
    Uart uart(device_);
    uart.queue_failure = EINVAL;
    EXPECT_EQ(end_of(uart), (End{1, {}, 0}));
}

}  // namespace
}  // namespace tribus::test::serial_uart_test
