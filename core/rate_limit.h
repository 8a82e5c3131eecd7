#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "core/time.h"

namespace tribus {

/// Lets at most `burst` events pass in each `window` and counts the others. Pure; thread-bound.
class RateLimit {
  public:
    RateLimit(unsigned burst, Duration window) : burst_(burst), window_(window) {}

    /// Whether `pass` would let an event pass. Counts nothing.
    bool may_be_temporary(Instant now) const { return now >= window_end_ || passed_ < burst_; }
    /// Returns the number of events that were suppressed before this one, or nothing if this event
    /// is suppressed too.
    std::optional<std::uint64_t> pass(Instant now) {
        if (now >= window_end_) {
            window_end_ = later(now, window_);
            passed_ = 0;
        }
        if (!may_be_temporary(now)) {
            ++suppressed_;
            return std::nullopt;
        }
        ++passed_;
        return std::exchange(suppressed_, 0);
    }

  private:
    unsigned burst_;
    Duration window_;
    Instant window_end_{};
    unsigned passed_ = 0;
    std::uint64_t suppressed_ = 0;
};

}  // namespace tribus
