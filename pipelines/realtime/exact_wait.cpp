#include "pipelines/realtime/exact_wait.h"

#include <poll.h>

#include <cerrno>

namespace tribus {

bool has_epoll_pwait2(int epoll) {
    epoll_event event{};
    const timespec at_once{};
    return ::epoll_pwait2(epoll, &event, 1, &at_once, nullptr) >= 0 || errno != ENOSYS;
}

int wait_for_events(int epoll, std::span<epoll_event> events, const timespec& timeout,
                    bool has_epoll_pwait2) {
    const int most = static_cast<int>(events.size());
    if (has_epoll_pwait2) {
        return ::epoll_pwait2(epoll, events.data(), most, &timeout, nullptr);
    }
    pollfd any{.fd = epoll, .events = POLLIN, .revents = 0};
    const int ready = ::ppoll(&any, 1, &timeout, nullptr);
    return ready > 0 ? ::epoll_wait(epoll, events.data(), most, 0) : ready;
}

}  // namespace tribus
