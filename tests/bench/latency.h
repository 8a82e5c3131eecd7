#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/distribution.h"
#include "core/time.h"
#include "tests/bench/subject.h"

namespace tribus::bench {

/// Latency and losses of one subject.
struct LatencyResult {
    Distribution latency;  ///< from before the write of a frame to after the read of its last byte
    std::uint64_t lost = 0;
    std::uint64_t torn = 0;
    Duration processor_time_per_frame{};
};

/// Time between two frames, as from a receiver.
inline constexpr Duration kFramePeriod = std::chrono::milliseconds(7);

/// Gives each subject one frame in each period, one after the other, so that all see the same
/// machine and none is disturbed by another's frame. Ends after `length` or when interrupted. The
/// calling thread should hold a `TesterPriority`. Returns one result for each subject.
std::vector<LatencyResult> measure_latency(std::span<Subject* const> subjects, Duration length);

/// How all lanes of one subject are driven.
struct DriveSettings {
    Duration period = kFramePeriod;  ///< of each lane
    std::uint64_t rounds = 0;        ///< frames for each lane
    bool at_one_instant = false;  ///< send on all lanes at once, instead of evenly over the period
};

/// Sends through all lanes of a subject and checks what comes out. A lane whose last frame is still
/// on its way skips its turn.
LatencyResult drive(Subject& subject, const DriveSettings& settings);

}  // namespace tribus::bench
