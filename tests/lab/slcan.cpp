#include "tests/lab/slcan.h"

#include <fcntl.h>
#include <linux/tty.h>
#include <net/if.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/lab/can_bus.h"
#include "tests/lab/shell.h"
#include "tests/loopback/program.h"

namespace tribus::test {
namespace {

constexpr int kSlcanDiscipline = N_SLCAN;

void make_raw(int fd) {
    termios line{};
    EXPECT_EQ(::tcgetattr(fd, &line), 0) << std::strerror(errno);
    ::cfmakeraw(&line);
    EXPECT_EQ(::tcsetattr(fd, TCSANOW, &line), 0) << std::strerror(errno);
}

}  // namespace

SlcanAdapter::SlcanAdapter() {
    // The kernel creates the interface in the host's network namespace, whatever the test's own is.
    require_guest();
    // Not every distribution lets the kernel load a line discipline by itself.
    run_shell("modprobe slcan");
    plug();
}

SlcanAdapter::~SlcanAdapter() {
    unplug();
}

void SlcanAdapter::plug() {
    master_ = UniqueFd(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    std::array<char, 64> slave{};
    ASSERT_TRUE(::grantpt(master_.get()) == 0 && ::unlockpt(master_.get()) == 0 &&
                ::ptsname_r(master_.get(), slave.data(), slave.size()) == 0);
    slave_ = UniqueFd(::open(slave.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
    ASSERT_TRUE(slave_.valid()) << slave.data() << ": " << std::strerror(errno);
    make_raw(slave_.get());
    ASSERT_EQ(::ioctl(slave_.get(), TIOCSETD, &kSlcanDiscipline), 0)
        << "no SLCAN: " << std::strerror(errno);
    ifreq interface {};
    ASSERT_EQ(::ioctl(slave_.get(), SIOCGIFNAME, &interface), 0) << std::strerror(errno);
    name_ = interface.ifr_name;
    blocked_ = false;
    // Before the interface is set up, because the driver waits until its commands have been read.
    listener_ = std::jthread([this](const std::stop_token& stop) { listen(stop); });
    shell("ip link set dev " + name_ + " up type can bitrate 1000000");
}

void SlcanAdapter::unplug() {
    if (!master_.valid()) {
        return;
    }
    blocked_ = false;
    // A driver that still has something to send waits for a listener.
    run_shell("ip link set dev " + name_ + " down");
    listener_ = std::jthread();
    master_ = UniqueFd();
    slave_ = UniqueFd();
    EXPECT_TRUE(eventually([this] { return interface_index(name_) == 0; })) << name_;
}

void SlcanAdapter::say(const std::string& line) {
    const std::string bytes = line + "\r";
    EXPECT_EQ(::write(master_.get(), bytes.data(), bytes.size()), std::ssize(bytes)) << line;
}

std::vector<std::string> SlcanAdapter::heard(std::size_t known) const {
    const std::lock_guard lock(mutex_);
    return {heard_.begin() + static_cast<std::ptrdiff_t>(std::min(known, heard_.size())),
            heard_.end()};
}

void SlcanAdapter::listen(const std::stop_token& stop) {
    constexpr int kLookAgainMilliseconds = 5;
    std::array<char, 256> buffer{};
    while (!stop.stop_requested()) {
        pollfd ready{.fd = master_.get(), .events = POLLIN, .revents = 0};
        if (blocked_ || ::poll(&ready, 1, kLookAgainMilliseconds) <= 0) {
            ::poll(nullptr, 0, kLookAgainMilliseconds);
            continue;
        }
        const ssize_t count = ::read(master_.get(), buffer.data(), buffer.size());
        const std::lock_guard lock(mutex_);
        for (ssize_t at = 0; at < count; ++at) {
            const char letter = buffer[static_cast<std::size_t>(at)];
            if (letter == '\r') {
                heard_.push_back(partial_);
                partial_.clear();
            } else {
                partial_ += letter;
            }
        }
    }
}

}  // namespace tribus::test
