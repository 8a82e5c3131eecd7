#pragma once

#include <optional>

#include "core/time.h"

namespace tribus {

/// Whether the system clock was set between two looks at both clocks, apart from what it is slewed:
/// stamps from before the second look do not tell ages then.
class ClockStep {
  public:
    /// `wall_time` is that of the system clock at `now`.
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
