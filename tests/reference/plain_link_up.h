#pragma once

#include <chrono>

#include "core/time.h"

/// When a flight controller counts a link as up, as a plain rule: Betaflight's flight/failsafe.c
/// and rx/rx.c. Frames that are marked frame-lost or failsafe are not valid there.
namespace tribus::reference {

class PlainLinkUp {
  public:
    /// `start`: when the program starts. Nothing was valid before.
    explicit PlainLinkUp(Instant start) : latest_failure_(start) {}

    /// Call with rising times.
    void valid_frame(Instant at) {
        look(at);
        latest_valid_ = at;
        ever_valid_ = true;
        up_ = up_ || at - latest_failure_ > kRecovery;
    }
    bool is_up(Instant now) {
        look(now);
        return up_;
    }

  private:
    /// Without a valid frame for so long, the link fails at each moment until the next one.
    static constexpr Duration kFailsAfter = std::chrono::milliseconds(150);
    static constexpr Duration kRecovery = std::chrono::milliseconds(500);

    void look(Instant now) {
        if (!ever_valid_ || now - latest_valid_ > kFailsAfter) {
            latest_failure_ = now;
            up_ = false;
        }
    }

    Instant latest_failure_;
    Instant latest_valid_{};
    bool ever_valid_ = false;
    bool up_ = false;
};

}  // namespace tribus::reference
