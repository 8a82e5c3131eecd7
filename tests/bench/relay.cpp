#include "tests/bench/relay.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>

#include "pipelines/realtime/clock.h"

namespace tribus::bench {
namespace {

struct Ends {
    int in = -1;
    int out = -1;
};

int open_raw(const std::string& device) {
    const int descriptor = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    termios settings{};
    if (descriptor < 0 || ::tcgetattr(descriptor, &settings) != 0) {
        return -1;
    }
    ::cfmakeraw(&settings);
    return ::tcsetattr(descriptor, TCSANOW, &settings) == 0 ? descriptor : -1;
}

/// Returns false if the other side is gone.
bool carry(const Ends& ends) {
    std::array<std::uint8_t, 256> buffer;
    const ssize_t count = ::read(ends.in, buffer.data(), buffer.size());
    if (count > 0) {
        return ::write(ends.out, buffer.data(), static_cast<std::size_t>(count)) == count;
    }
    return count < 0 && errno == EAGAIN;
}

int relay_with_poll(const std::vector<Ends>& ends, const timespec* timeout) {
    std::vector<pollfd> waits;
    waits.reserve(ends.size());
    for (const Ends& pair : ends) {
        waits.push_back({.fd = pair.in, .events = POLLIN, .revents = 0});
    }
    while (::ppoll(waits.data(), waits.size(), timeout, nullptr) >= 0) {
        for (std::size_t i = 0; i < waits.size(); ++i) {
            if (waits[i].revents != 0 && !carry(ends[i])) {
                return 1;
            }
        }
    }
    return 1;
}

int relay_with_epoll(const std::vector<Ends>& ends, const timespec* timeout) {
    constexpr int kEventsPerWake = 64;
    const int epoll = ::epoll_create1(0);
    for (std::size_t i = 0; i < ends.size(); ++i) {
        epoll_event event{};
        event.events = EPOLLIN;
        event.data.u64 = i;
        ::epoll_ctl(epoll, EPOLL_CTL_ADD, ends[i].in, &event);
    }
    std::array<epoll_event, kEventsPerWake> events;
    int count = 0;
    while ((count = ::epoll_pwait2(epoll, events.data(), kEventsPerWake, timeout, nullptr)) >= 0) {
        for (int i = 0; i < count; ++i) {
            const epoll_event& event = events[static_cast<std::size_t>(i)];
            if (!carry(ends[static_cast<std::size_t>(event.data.u64)])) {
                return 1;
            }
        }
    }
    return 1;
}

bool take_scheduling(const RelaySettings& settings) {
    if (settings.cpu) {
        cpu_set_t cpus;
        CPU_ZERO(&cpus);
        CPU_SET(static_cast<std::size_t>(*settings.cpu), &cpus);
        if (::sched_setaffinity(0, sizeof cpus, &cpus) != 0) {
            return false;
        }
    }
    if (!settings.priority) {
        return true;
    }
    const sched_param parameters{.sched_priority = *settings.priority};
    return ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0 &&
           ::sched_setscheduler(0, SCHED_FIFO, &parameters) == 0;
}

}  // namespace

int run_relay(const std::vector<std::pair<std::string, std::string>>& devices,
              const RelaySettings& settings) {
    std::vector<Ends> ends;
    ends.reserve(devices.size());
    for (const auto& [in, out] : devices) {
        ends.push_back({.in = open_raw(in), .out = open_raw(out)});
        if (ends.back().in < 0 || ends.back().out < 0) {
            std::perror("cannot open a device of the bare relay");
            return 1;
        }
    }
    if (!take_scheduling(settings)) {
        std::perror("no real-time scheduling for the bare relay");
        return 1;
    }
    const timespec timeout = as_timespec(settings.timeout.value_or(Duration::zero()));
    const timespec* wait = settings.timeout ? &timeout : nullptr;
    return settings.waits == RelaySettings::Waits::poll ? relay_with_poll(ends, wait)
                                                        : relay_with_epoll(ends, wait);
}

}  // namespace tribus::bench
