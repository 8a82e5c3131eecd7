#include "tests/lab/uart.h"

// <termios.h> has neither termios2 nor BOTHER and conflicts with this header.
#include <asm/termbits.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include <gtest/gtest.h>

#include "tests/lab/shell.h"
#include "tests/loopback/program.h"

namespace tribus::test {
namespace {

// The path in run_guest.
constexpr const char* kTraceFile = "/lab/trace";

std::filesystem::path usb_device(int port) {
    return "/sys/bus/usb/devices/1-" + std::to_string(port);
}

/// Returns the only entry of `folder` that begins with `beginning`, once it and its node exist.
std::string device_in(const std::filesystem::path& folder, const std::string& beginning) {
    require_guest();
    std::string node;
    EXPECT_TRUE(eventually([&] {
        std::error_code none;
        for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
            const std::string name = entry.path().filename();
            if (name.starts_with(beginning)) {
                node = "/dev/" + name;
            }
        }
        return !node.empty() && std::filesystem::exists(node);
    })) << "no "
        << beginning << " in " << folder << "; this test runs in a guest of the laboratory";
    return node;
}

}  // namespace

LineSeen line_of(int descriptor) {
    struct termios2 line {};
    EXPECT_EQ(::ioctl(descriptor, TCGETS2, &line), 0) << std::strerror(errno);
    return {.baud = line.c_ospeed,
            .parity = (line.c_cflag & PARENB) != 0,
            .two_stop_bits = (line.c_cflag & CSTOPB) != 0,
            .eight_data_bits = (line.c_cflag & CSIZE) == CS8};
}

Uart::Uart(const std::string& device, const LineSettings& settings)
    : fd_(::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    EXPECT_TRUE(fd_.valid()) << device << ": " << std::strerror(errno);
    struct termios2 line {};
    line.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
    line.c_cflag |= settings.parity == Parity::even ? PARENB : 0U;
    line.c_cflag |= settings.stop_bits == 2 ? CSTOPB : 0U;
    line.c_ispeed = settings.baud;
    line.c_ospeed = settings.baud;
    line.c_cc[VMIN] = 1;
    EXPECT_EQ(::ioctl(fd_.get(), TCSETSF2, &line), 0) << device << ": " << std::strerror(errno);
}

void Uart::send(std::span<const std::uint8_t> bytes) {
    std::size_t sent = 0;
    EXPECT_TRUE(eventually([&] {
        const ssize_t taken = ::write(fd_.get(), bytes.data() + sent, bytes.size() - sent);
        sent += taken > 0 ? static_cast<std::size_t>(taken) : 0;
        return sent == bytes.size();
    })) << std::strerror(errno);
}

Bytes Uart::receive() {
    Bytes all;
    std::array<std::uint8_t, 4096> buffer{};
    ssize_t count = 0;
    while ((count = ::read(fd_.get(), buffer.data(), buffer.size())) > 0) {
        all.insert(all.end(), buffer.begin(), buffer.begin() + count);
    }
    return all;
}

Bytes Uart::receive(std::size_t count) {
    Bytes all;
    eventually([&] {
        const Bytes more = receive();
        all.insert(all.end(), more.begin(), more.end());
        return all.size() >= count;
    });
    return all;
}

std::string ftdi_adapter(int usb_port) {
    return device_in("/sys/bus/usb/devices/1-" + std::to_string(usb_port) + ":1.0", "ttyUSB");
}

std::string uart_16550(int number) {
    // Slots 10.0 and 11.0, in hexadecimal.
    return device_in("/sys/bus/pci/devices/0000:00:1" + std::to_string(number - 1) + ".0/tty",
                     "ttyS");
}

std::string far_end_of_pl011() {
    return device_in("/sys/bus/usb/devices/1-1.1/1-1.1:1.0", "ttyUSB");
}

std::string far_end_of_mini_uart() {
    return device_in("/sys/bus/usb/devices/1-1.2/1-1.2:1.0", "ttyUSB");
}

void unplug_usb(int usb_port) {
    write_kernel_file(usb_device(usb_port) / "authorized", "0");
}

void plug_usb(int usb_port) {
    write_kernel_file(usb_device(usb_port) / "authorized", "1");
}

ProgrammedLines::ProgrammedLines() : before_(read_file(kTraceFile).size()) {}

std::string ProgrammedLines::trace() const {
    return read_file(kTraceFile).substr(before_);
}

void ProgrammedLines::expect(const std::string& text) const {
    EXPECT_TRUE(eventually([&] { return trace().find(text) != std::string::npos; }))
        << "not programmed: " << text << "; only:\n"
        << trace();
}

}  // namespace tribus::test
