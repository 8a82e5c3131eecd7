#pragma once

#include <sys/epoll.h>

#include <ctime>
#include <span>

namespace tribus {

/// Whether epoll_pwait2 works: the kernel has it (Linux 5.11), and no filter of system calls
/// refuses it. `epoll` is any epoll descriptor.
bool has_epoll_pwait2(int epoll);

/// epoll_wait with a timeout in nanoseconds. Returns the number of events, or -1 with errno set.
/// Without epoll_pwait2 it takes one more system call. Thread-safe.
int wait_for_events(int epoll, std::span<epoll_event> events, const timespec& timeout,
                    bool has_epoll_pwait2);

}  // namespace tribus
