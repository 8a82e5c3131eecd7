#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "transports/links/unique_fd.h"

namespace tribus {

struct SchedulingSettings {
    int priority = 80;
    std::optional<int> cpu;
    /// All of real time; pinning alone if false.
    bool realtime = true;
};

/// The stack of a thread that is made real-time: locked memory counts all of it, and the default
/// is 8 MB.
inline constexpr std::size_t kRealtimeStackBytes = std::size_t{128} * 1024;

/// What a thread got of real time.
struct Scheduling {
    /// What could not be had, each as a sentence that says how to get it; empty when all is well.
    std::vector<std::string> missing;
    /// While it is open, no processor sleeps so deeply that waking takes long.
    UniqueFd wide_awake;
};

/// Gives the calling thread real-time scheduling: SCHED_FIFO at `priority`, timers without slack,
/// the process's memory locked, its own stack in memory, processors that wake at once, pinned to
/// `cpu`. Call on the data thread before it starts; its stack has `kRealtimeStackBytes`.
[[nodiscard]] Scheduling make_realtime(const SchedulingSettings& settings);

/// A program that is stopped in the middle of a write begins it anew when it goes on, with the
/// bytes of long ago, unless a signal comes that it handles. SIGCONT is one from here on, and
/// reaches only a thread that calls `hear_of_stops`. Main thread, before all others.
void keep_stops_from_threads();
/// Calls of the kernel in this thread end with EINTR where a stop cut into them.
void hear_of_stops();

}  // namespace tribus
