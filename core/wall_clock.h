#pragma once

#include "core/time.h"

namespace tribus {

/// The time of day, for parts that know instants only. It may jump, as the machine's own does.
class WallClock {
  public:
    WallClock() = default;
    WallClock(const WallClock&) = delete;
    WallClock& operator=(const WallClock&) = delete;
    virtual ~WallClock() = default;
    /// Time since 1970, UTC, at `now`. Thread-safe.
    virtual Duration at(Instant now) const = 0;
    /// `now` on a clock whose rate nobody adjusts. Programs that set the time slow down the clock
    /// of instants, too, or make it faster, by up to a tenth. Thread-safe.
    virtual Instant unslewed(Instant now) const = 0;
    /// Whether the machine knows that the time is right. Thread-safe.
    virtual bool is_set() const = 0;
};

}  // namespace tribus
