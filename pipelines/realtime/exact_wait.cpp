#include "pipelines/realtime/exact_wait.h"

#include <linux/time_types.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>

namespace tribus {

namespace {

/// Not by the C library's function, which is a cancellation point: see direct_call.h.
int wait_exactly(int epoll, epoll_event* events, int most, const timespec& timeout) {
    // It has 64 bits on every processor.
    const __kernel_timespec time{.tv_sec = timeout.tv_sec, .tv_nsec = timeout.tv_nsec};
    return static_cast<int>(
        ::syscall(SYS_epoll_pwait2, epoll, events, most, &time, nullptr, std::size_t{0}));
}

}  // namespace

bool has_epoll_pwait2(int epoll) {
    epoll_event event{};
    return wait_exactly(epoll, &event, 1, {}) >= 0 || errno == EINTR;
}

int wait_for_events(int epoll, std::span<epoll_event> events, const timespec& timeout,
                    bool has_epoll_pwait2) {
    const int most = static_cast<int>(events.size());
    if (has_epoll_pwait2) {
        return wait_exactly(epoll, events.data(), most, timeout);
    }
    pollfd any{.fd = epoll, .events = POLLIN, .revents = 0};
    const int ready = ::ppoll(&any, 1, &timeout, nullptr);
    return ready > 0 ? static_cast<int>(::syscall(SYS_epoll_pwait, epoll, events.data(), most, 0,
                                                  nullptr, std::size_t{0}))
                     : ready;
}

}  // namespace tribus
