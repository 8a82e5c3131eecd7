#pragma once

#include <ctime>

#include "core/time.h"

namespace tribus {

/// The clock of all instants: it never jumps, and goes on while the machine is suspended, so that
/// what was there before has its true age afterwards.
inline constexpr clockid_t kClock = CLOCK_BOOTTIME;

/// What it says. The only place in the project that reads a clock. Thread-safe.
Instant monotonic_now();

/// CLOCK_MONOTONIC, which stands still meanwhile: only for those who ask for it by its name, as
/// systemd does. Thread-safe.
Duration awake_time_now();

/// The system clock, since 1970: only for comparison with stamps of the kernel that are on it. It
/// may jump. Thread-safe.
Duration wall_time_now();

/// As system calls take it; 0 for a negative one. Pure.
std::timespec as_timespec(Duration duration);

}  // namespace tribus
