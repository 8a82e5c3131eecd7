#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "core/time.h"

namespace tribus {

/// Answers "may I say this now, and how often was I silent since?": at most `burst` times in each
/// `window`. Pure; thread-bound.
class RateLimit {
  public:
    RateLimit(unsigned burst, Duration window) : burst_(burst), window_(window) {}

    /// Whether `pass` would let one through; counts nothing.
    bool may_pass(Instant now) const { return now >= window_end_ || said_ < burst_; }
    /// The number of times that were swallowed before, if it may be said now.
    std::optional<std::uint64_t> pass(Instant now) {
        if (now >= window_end_) {
            window_end_ = later(now, window_);
            said_ = 0;
        }
        if (!may_pass(now)) {
            ++swallowed_;
            return std::nullopt;
        }
        ++said_;
        return std::exchange(swallowed_, 0);
    }

  private:
    unsigned burst_;
    Duration window_;
    Instant window_end_{};
    unsigned said_ = 0;
    std::uint64_t swallowed_ = 0;
};

}  // namespace tribus
