#include "pipelines/realtime/clock.h"

#include <sys/timex.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

namespace tribus {

namespace {

static_assert(sizeof(std::time_t) >= 8, "a time of 32 bits ends in 2038: -D_TIME_BITS=64");

class FollowedClock final : public WallClock {
  public:
    /// `slewed`: by how much adjustments of its rate have made the clock of instants slower.
    void set(Duration since_1970, Instant now, Duration slewed, bool is_set) {
        ahead_.store((since_1970 - now.time_since_epoch()).count(), std::memory_order_relaxed);
        slewed_.store(slewed.count(), std::memory_order_relaxed);
        // A reader that sees that the clock is set sees its time, too.
        is_set_.store(is_set, std::memory_order_release);
    }
    Duration at(Instant now) const override {
        return now.time_since_epoch() + Duration(ahead_.load(std::memory_order_relaxed));
    }
    Instant unslewed(Instant now) const override {
        return now + Duration(slewed_.load(std::memory_order_relaxed));
    }
    bool is_set() const override { return is_set_.load(std::memory_order_acquire); }

  private:
    /// Nanoseconds from the zero of instants to 1970.
    std::atomic<std::int64_t> ahead_{0};
    std::atomic<std::int64_t> slewed_{0};
    std::atomic<bool> is_set_{false};
};

FollowedClock& followed_clock() {
    static FollowedClock clock;
    return clock;
}

Duration read_clock(clockid_t clock) {
    timespec now{};
    ::clock_gettime(clock, &now);
    return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

struct Clocks {
    Instant now{};
    Duration wall{};
    Duration awake{};
    Duration raw{};
    Duration took{};  ///< to read them
};

Clocks read_clocks() {
    Clocks clocks{.now = monotonic_now(), .wall = wall_time_now(), .awake = awake_time_now()};
    clocks.raw = read_clock(CLOCK_MONOTONIC_RAW);
    clocks.took = monotonic_now() - clocks.now;
    return clocks;
}

/// Judges by the most that the clock may be off, as the kernel knows. STA_UNSYNC says less:
/// programs that set the time leave it on where the kernel must not write the RTC.
bool is_wall_clock_set() {
    constexpr long kUnknownError = 16'000'000;  // microseconds, NTP_PHASE_LIMIT of the kernel
    timex asked{};
    return ::adjtimex(&asked) >= 0 && asked.maxerror < kUnknownError;
}

}  // namespace

Instant monotonic_now() {
    return Instant(read_clock(kClock));
}

Duration awake_time_now() {
    return read_clock(CLOCK_MONOTONIC);
}

Duration wall_time_now() {
    return read_clock(CLOCK_REALTIME);
}

const WallClock& wall_clock() {
    return followed_clock();
}

void follow_wall_clock() {
    // Asked before the time: a clock that is being set is not taken for set at its old time.
    const bool is_set = is_wall_clock_set();
    constexpr Duration kClose = std::chrono::microseconds(100);
    Clocks clocks = read_clocks();
    // The thread may have been interrupted between two clocks.
    for (int more = 0; more < 4 && clocks.took > kClose; ++more) {
        const Clocks again = read_clocks();
        clocks = again.took < clocks.took ? again : clocks;
    }
    followed_clock().set(clocks.wall, clocks.now, clocks.raw - clocks.awake, is_set);
}

std::timespec as_timespec(Duration duration) {
    const Duration positive = std::max(duration, Duration::zero());
    const auto seconds = std::chrono::floor<std::chrono::seconds>(positive);
    std::timespec time{};
    time.tv_sec = static_cast<decltype(time.tv_sec)>(seconds.count());
    time.tv_nsec = static_cast<decltype(time.tv_nsec)>((positive - seconds).count());
    return time;
}

}  // namespace tribus
