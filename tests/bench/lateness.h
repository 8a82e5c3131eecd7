#pragma once

#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "core/distribution.h"
#include "core/time.h"

namespace tribus::bench {

/// Scheduling of both threads.
struct LatenessSettings {
    std::optional<int> priority;  ///< SCHED_FIFO, with memory locked
    std::optional<int> cpu;
    Duration length = std::chrono::seconds(2);
};

struct LatenessResult {
    Distribution grid;  ///< from an output's deadline to its write
    Distribution bare;  ///< from a timer's deadline to the return of clock_nanosleep
};

/// Period of both.
inline constexpr Duration kGridPeriod = std::chrono::milliseconds(7);

/// Runs the engine, loop and data thread of tribus with one output of schedule `grid`, and at the
/// same time, half a period apart, a thread that only sleeps until absolute instants. The error is
/// a sentence.
tl::expected<LatenessResult, std::string> measure_lateness(const LatenessSettings& settings);

}  // namespace tribus::bench
