#pragma once

#include <optional>

#include "core/time.h"

namespace tribus {

/// Detects whether the system clock was set between two looks at both clocks; slewing does not
/// count. If so, time stamps from before the second look give no ages. Pure; thread-bound.
class ClockStep {
  public:
    /// Whether the clock was set since the latest look. `wall_time` is the system clock at `now`.
    bool since_last_look(Duration wall_time, Instant now) const;
    void look(Duration wall_time, Instant now);

  private:
    struct Look {
        Duration wall_time{};
        Instant at{};
    };
    std::optional<Look> latest_;
};

}  // namespace tribus
