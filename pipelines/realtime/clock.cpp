#include "pipelines/realtime/clock.h"

#include <time.h>

namespace tribus {

namespace {

Duration read_clock(clockid_t clock) {
    timespec now{};
    ::clock_gettime(clock, &now);
    return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

}  // namespace

Instant monotonic_now() {
    return Instant(read_clock(CLOCK_MONOTONIC));
}

Duration wall_time_now() {
    return read_clock(CLOCK_REALTIME);
}

}  // namespace tribus
