#pragma once

#include <optional>
#include <string>
#include <vector>

namespace tribus {

struct SchedulingSettings {
    int priority = 80;
    std::optional<int> cpu;
    /// SCHED_FIFO and locked memory; pinning alone if false.
    bool realtime = true;
};

/// Gives the calling thread real-time scheduling: SCHED_FIFO at `priority`, the process's memory
/// locked, pinned to `cpu`. Returns what could not be had, each as a sentence that says how to get
/// it; empty when all is well. Call on the data thread before it starts.
std::vector<std::string> make_realtime(const SchedulingSettings& settings);

}  // namespace tribus
