#pragma once

#include <atomic>
#include <cstdint>

#include "core/time.h"

namespace tribus {

/// The time of day, for parts that know instants only. One thread keeps it right, any thread reads
/// it. It may jump, as the machine's own does.
class WallClock {
  public:
    constexpr WallClock() = default;
    WallClock(Duration since_1970, Instant now) { set(since_1970, now); }

    /// At `now` it is so long since 1970, UTC.
    void set(Duration since_1970, Instant now) {
        ahead_.store((since_1970 - now.time_since_epoch()).count(), std::memory_order_relaxed);
    }
    /// Time since 1970, UTC, at `now`.
    Duration at(Instant now) const {
        return now.time_since_epoch() + Duration(ahead_.load(std::memory_order_relaxed));
    }

  private:
    /// Nanoseconds from the zero of instants to 1970.
    std::atomic<std::int64_t> ahead_{0};
};

}  // namespace tribus
