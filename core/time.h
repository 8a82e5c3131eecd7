#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace tribus {

/// Tag of the one time line that the project knows: monotonic, zero anywhere. It has no now():
/// time is an argument everywhere, and only pipelines/realtime/clock.cpp asks the machine for it.
/// Wall-clock times have another tag and do not compile in its place.
struct MonotonicTag {};

using Duration = std::chrono::nanoseconds;
using Instant = std::chrono::time_point<MonotonicTag, Duration>;

/// "No deadline": later than every instant that occurs.
inline constexpr Instant kNever = Instant::max();

/// `instant + duration` that stays at kNever instead of overflowing.
constexpr Instant later(Instant instant, Duration duration) {
    return duration > kNever - std::max(instant, Instant{}) ? kNever : instant + duration;
}

}  // namespace tribus
