#include "tests/soak/bare_timer.h"

#include <pthread.h>

#include <ctime>

#include "pipelines/realtime/clock.h"

namespace tribus::test {

void BareTimer::run() {
    constexpr Duration kPeriod = std::chrono::milliseconds(7);
    constexpr sched_param kPriority{.sched_priority = 80};
    ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &kPriority);
    for (Instant due = later(monotonic_now(), kPeriod); !ends_; due = later(due, kPeriod)) {
        const auto whole = std::chrono::floor<std::chrono::seconds>(due.time_since_epoch());
        const timespec until{.tv_sec = whole.count(),
                             .tv_nsec = (due.time_since_epoch() - whole).count()};
        ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
        ++wakes_;
        misses_ += monotonic_now() - due > kPeriod / 10 ? 1 : 0;
    }
}

}  // namespace tribus::test
