#pragma once

#include <ctime>

#include "core/time.h"

namespace tribus {

/// The machine's monotonic clock. The only place in the project that reads a clock. Thread-safe.
Instant monotonic_now();

/// The system clock, since 1970: only for comparison with stamps of the kernel that are on it. It
/// may jump. Thread-safe.
Duration wall_time_now();

/// As system calls take it; 0 for a negative one. Pure.
std::timespec as_timespec(Duration duration);

}  // namespace tribus
