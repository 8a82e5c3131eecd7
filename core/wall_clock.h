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
};

}  // namespace tribus
