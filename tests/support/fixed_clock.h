#pragma once

#include "core/wall_clock.h"

namespace tribus::test {

/// A clock that tests set. It counts as set unless a test says otherwise.
class FixedClock final : public WallClock {
  public:
    /// At `now` it is so long since 1970.
    FixedClock(Duration since_1970, Instant now) { set(since_1970, now); }
    void set(Duration since_1970, Instant now) { ahead_ = since_1970 - now.time_since_epoch(); }
    void never_set() { is_set_ = false; }
    /// The clock of instants has lost so much because its rate was adjusted.
    void set_lost(Duration lost) { lost_ = lost; }
    Duration at(Instant now) const override { return now.time_since_epoch() + ahead_; }
    Instant unslewed(Instant now) const override { return now + lost_; }
    bool is_set() const override { return is_set_; }

  private:
    Duration ahead_{};
    Duration lost_{};
    bool is_set_ = true;
};

}  // namespace tribus::test
