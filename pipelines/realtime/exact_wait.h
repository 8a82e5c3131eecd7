#pragma once

#include <sys/epoll.h>

#include <ctime>
#include <span>

namespace tribus {

/// Whether the kernel has it (Linux 5.11); `epoll` is any epoll descriptor.
bool has_epoll_pwait2(int epoll);

/// epoll_wait with a timeout as exact as a sleep's. Returns the number of events, or -1 with errno
/// set. Without epoll_pwait2 that takes one system call more. Thread-safe.
int wait_for_events(int epoll, std::span<epoll_event> events, const timespec& timeout,
                    bool has_epoll_pwait2);

}  // namespace tribus
