#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace tribus {

/// Tag of the only time line in the project: monotonic, with an arbitrary zero. It has no now():
/// time is an argument, and only pipelines/realtime/clock.cpp reads the clock. Wall-clock times
/// have another tag, so mixing them does not compile.
struct MonotonicTag {};

using Duration = std::chrono::nanoseconds;
using Instant = std::chrono::time_point<MonotonicTag, Duration>;

/// "No deadline": later than every instant that occurs.
inline constexpr Instant kNever = Instant::max();

/// `instant + duration`, limited to kNever.
constexpr Instant later(Instant instant, Duration duration) {
    return duration > kNever - std::max(instant, Instant{}) ? kNever : instant + duration;
}

}  // namespace tribus
