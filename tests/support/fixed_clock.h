#pragma once

#include "core/wall_clock.h"

namespace tribus::test {

/// A clock that tests set.
class FixedClock final : public WallClock {
  public:
    /// At `now` it is so long since 1970.
    FixedClock(Duration since_1970, Instant now) { set(since_1970, now); }
    void set(Duration since_1970, Instant now) { ahead_ = since_1970 - now.time_since_epoch(); }
    Duration at(Instant now) const override { return now.time_since_epoch() + ahead_; }

  private:
    Duration ahead_{};
};

}  // namespace tribus::test
