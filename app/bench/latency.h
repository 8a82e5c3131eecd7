#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "app/bench/distribution.h"
#include "app/bench/subject.h"
#include "core/time.h"

namespace tribus::bench {

/// What one subject did to the frames that it was given.
struct LatencyResult {
    Distribution latency;  ///< from before the write of a frame to after the read of its last byte
    std::uint64_t lost = 0;
    std::uint64_t torn = 0;
    Duration processor_time_per_frame{};
};

/// Time from one frame to the next, as a receiver's.
inline constexpr Duration kFramePeriod = std::chrono::milliseconds(7);

/// Gives each of the subjects a frame in each period, one after the other, so that all of them see
/// the same machine, and none another one's frame. For `length`, or until interrupted. The calling
/// thread should have `TesterPriority`. One result for each subject.
std::vector<LatencyResult> measure_latency(std::span<Subject* const> subjects, Duration length);

/// How the lanes of one subject are used at the same time.
struct DriveSettings {
    Duration period = kFramePeriod;  ///< of each lane
    std::uint64_t rounds = 0;        ///< frames a lane
    bool at_one_instant = false;     ///< all lanes at once, else spread evenly over the period
};

/// Sends through all lanes of a subject at once, and judges what comes out. A lane whose last frame
/// is still under way misses its turn.
LatencyResult drive(Subject& subject, const DriveSettings& settings);

}  // namespace tribus::bench
