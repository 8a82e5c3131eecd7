#pragma once

#include <ctime>

#include "core/time.h"
#include "core/wall_clock.h"

namespace tribus {

/// The clock of all instants. It never jumps, and it runs while the machine is suspended, so that
/// data from before has its true age afterwards.
inline constexpr clockid_t kClock = CLOCK_BOOTTIME;

/// Time on kClock. This file is the only one in the project that reads a clock. Thread-safe.
Instant monotonic_now();

/// CLOCK_MONOTONIC, which stops while the machine is suspended. Only for interfaces that require
/// it, such as systemd's. Thread-safe.
Duration awake_time_now();

/// The system clock, since 1970. Only for comparison with kernel time stamps on that clock. It may
/// jump. Thread-safe.
Duration wall_time_now();

/// The system clock for parts that know instants only, as right as at the latest call of
/// `follow_wall_clock`. It counts as set while the kernel knows how far it is off at most, and not
/// where a filter of system calls refuses to tell. It is there until the program ends. Thread-safe.
const WallClock& wall_clock();
/// Brings `wall_clock` up to date. Thread-safe.
void follow_wall_clock();

/// Converts for system calls. A negative duration becomes 0. Pure.
std::timespec as_timespec(Duration duration);

}  // namespace tribus
