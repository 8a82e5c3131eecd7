#pragma once

#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "app/bench/distribution.h"
#include "core/time.h"

namespace tribus::bench {

/// How both are scheduled.
struct LatenessSettings {
    std::optional<int> priority;  ///< SCHED_FIFO, with memory locked
    std::optional<int> cpu;
    Duration length = std::chrono::seconds(2);
};

struct LatenessResult {
    Distribution grid;  ///< from an output's deadline to its write
    Distribution bare;  ///< from a timer's to the return of clock_nanosleep
};

/// The period of both.
inline constexpr Duration kGridPeriod = std::chrono::milliseconds(7);

/// The product's engine, loop and data thread with one output of schedule `grid`, and at the same
/// time, half a period apart, a thread that does nothing but sleep until absolute instants. The
/// error is a sentence.
tl::expected<LatenessResult, std::string> measure_lateness(const LatenessSettings& settings);

}  // namespace tribus::bench
