#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "transports/links/unique_fd.h"

namespace tribus {

/// Scheduling of the data thread: SCHED_FIFO priority (1 to 99) and processor (absent: any).
struct SchedulingSettings {
    int priority = 80;
    std::optional<int> cpu;
    /// False: only pins the thread.
    bool realtime = true;
};

/// Stack size of a real-time thread. All of it is locked into memory, and the default is 8 MB.
inline constexpr std::size_t kRealtimeStackBytes = std::size_t{128} * 1024;

/// Real-time scheduling as granted to a thread.
struct Scheduling {
    /// Parts that were refused, each as a sentence that says how to get it.
    std::vector<std::string> missing;
    /// While it is open, processors do not enter sleep states with a long wake-up time.
    UniqueFd latency_limit;
};

/// Gives the calling thread real-time scheduling: SCHED_FIFO at `priority`, timers without slack,
/// locked memory of the process, its own stack in memory, processors without deep sleep, pinned to
/// `cpu`. Call on the data thread before it starts. Its stack has `kRealtimeStackBytes`.
[[nodiscard]] Scheduling make_realtime(const SchedulingSettings& settings);

/// Handles SIGCONT, and blocks it in all threads except those that call `unblock_sigcont`. Without
/// a handled signal, the kernel would restart a write that a stop interrupted, with bytes of long
/// ago. Main thread, before any other thread starts.
void handle_sigcont();
/// System calls of this thread return EINTR if a stop interrupted them.
void unblock_sigcont();

}  // namespace tribus
