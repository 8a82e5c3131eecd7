#pragma once

// termios2 is what the driver gets. <termios.h> conflicts with this header.
#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/device_stand_in.h"
#include "transports/links/serial/serial_port.h"
#include "transports/links/unique_fd.h"

namespace tribus::test {

inline constexpr LineSettings kSbusLine8E2{
    .baud = 100000, .parity = Parity::even, .stop_bits = 2, .inverted_wire = true};

/// ttyS1 of the 8250 driver: a pty that answers as serial_core.c and n_tty.c do (asm/ioctls.h,
/// linux/serial.h, linux/serial_core.h). TCGETS2 returns what TCSETS2 brought and the driver kept;
/// TIOCOUTQ and TIOCINQ the bytes that wait; TIOCGSERIAL and TIOCSSERIAL the driver's own settings.
/// The pty answers all that is not answered here.
class Uart : public DeviceStandIn {
  public:
    explicit Uart(const std::string& path, unsigned device_major = 4, unsigned device_minor = 65)
        : DeviceStandIn(path), number_(makedev(device_major, device_minor)) {
        driver.type = 4;  // a 16550A
        driver.baud_base = 24'000'000;
    }

    Answer state(struct stat& node) override {
        node.st_rdev = number_;
        return state_failure != 0 ? Answer(-state_failure) : std::nullopt;
    }

    Answer control(unsigned long request, void* argument) override {
        switch (request) {
            case TCSETS2:
                set = *static_cast<struct termios2*>(argument);
                return 0;
            case TCGETS2:
                *static_cast<struct termios2*>(argument) = kept();
                return 0;
            case TCFLSH:
                flushed.push_back(static_cast<int>(reinterpret_cast<std::intptr_t>(argument)));
                return 0;
            case TIOCGEXCL:
                *static_cast<int*>(argument) = exclusive;
                return 0;
            case TIOCEXCL:
            case TIOCNXCL:
                exclusive = request == TIOCEXCL ? 1 : 0;
                return 0;
            case TIOCGSERIAL:
                *static_cast<serial_struct*>(argument) = driver;
                return -driver_failure;
            case TIOCSSERIAL:
                driver_settings.push_back(*static_cast<serial_struct*>(argument));
                return 0;
            case TIOCOUTQ:
                return queued(argument);
            case TIOCINQ:
                *static_cast<int*>(argument) = unread;
                return -unread_failure;
            default:
                return std::nullopt;
        }
    }

    Answer read(std::span<std::uint8_t> room) override {
        ++reads;
        if (arrived.empty()) {
            return -read_failure;
        }
        const std::vector<std::uint8_t> bytes = arrived.front();
        arrived.pop_front();
        if (bytes.empty()) {
            return -EINTR;
        }
        std::copy(bytes.begin(), bytes.end(), room.begin());
        return static_cast<long>(bytes.size());
    }

    Answer write(std::span<const std::uint8_t> bytes) override {
        ++writes;
        return write_failure != 0 ? -write_failure : static_cast<long>(bytes.size()) - missing;
    }

    /// `set_flags` and `cleared_flags`: what the driver makes of the flags that it gets.
    struct termios2 kept() const {
        struct termios2 line = set;
        line.c_cflag = (line.c_cflag & ~cleared_flags) | set_flags;
        return line;
    }

    struct termios2 set {};
    tcflag_t cleared_flags = 0;
    tcflag_t set_flags = 0;
    int exclusive = 0;
    serial_struct driver{};
    int driver_failure = 0;
    std::vector<serial_struct> driver_settings{};
    std::vector<int> flushed{};
    /// Bytes that wait to be sent, at each question; the last number stays.
    std::deque<int> queue{0};
    int queue_failure = 0;
    int unread = 0;
    int unread_failure = 0;
    /// The bytes of each read; no bytes are a signal. Without reads left, they fail.
    std::deque<std::vector<std::uint8_t>> arrived{};
    int read_failure = EAGAIN;
    int reads = 0;
    int write_failure = 0;
    int missing = 0;
    int writes = 0;
    int state_failure = 0;

  private:
    long queued(void* argument) {
        *static_cast<int*>(argument) = queue.front();
        if (queue.size() > 1) {
            queue.pop_front();
        }
        return -queue_failure;
    }

    dev_t number_;
};

/// A pty for the stand-in.
class SerialUart : public ::testing::Test {
  protected:
    SerialUart() {
        EXPECT_EQ(::grantpt(wire_.get()), 0);
        EXPECT_EQ(::unlockpt(wire_.get()), 0);
        std::array<char, 64> name{};
        EXPECT_EQ(::ptsname_r(wire_.get(), name.data(), name.size()), 0);
        device_ = name.data();
    }

    std::unique_ptr<SerialPort> opened(const LineSettings& line = kSbusLine8E2) const {
        auto port = SerialPort::open(device_, line);
        EXPECT_TRUE(port.has_value()) << (port ? "" : port.error());
        return port ? std::move(*port) : nullptr;
    }

    /// Why it is refused, without the device's name.
    std::string refusal(const LineSettings& line = kSbusLine8E2) const {
        const auto port = SerialPort::open(device_, line);
        return port ? "it opened" : port.error().substr(device_.size() + 2);
    }

    UniqueFd wire_{::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    std::string device_;
};

}  // namespace tribus::test
