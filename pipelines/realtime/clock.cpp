#include "pipelines/realtime/clock.h"

#include <time.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

namespace tribus {

namespace {

static_assert(sizeof(std::time_t) >= 8, "a time of 32 bits ends in 2038: -D_TIME_BITS=64");

class FollowedClock final : public WallClock {
  public:
    void set(Duration since_1970, Instant now) {
        ahead_.store((since_1970 - now.time_since_epoch()).count(), std::memory_order_relaxed);
    }
    Duration at(Instant now) const override {
        return now.time_since_epoch() + Duration(ahead_.load(std::memory_order_relaxed));
    }

  private:
    /// Nanoseconds from the zero of instants to 1970.
    std::atomic<std::int64_t> ahead_{0};
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
    followed_clock().set(wall_time_now(), monotonic_now());
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
