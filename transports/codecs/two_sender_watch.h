#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/time.h"

namespace tribus {

/// Detects two senders of one CAN id by the arrivals alone: many frames have a successor one period
/// later, and for some of those another frame comes in between. It does not see two senders that
/// keep a half, a third or a quarter of a period apart, which look like a faster one; one that is
/// ten times as rare as the other; and senders that jitter by more than a few percent. So it may
/// miss two senders, but reports a single one as two only if that sends in pairs. Pure;
/// thread-bound; no heap.
class TwoSenderWatch {
  public:
    /// Number of arrivals that are judged together.
    static constexpr std::size_t kJudgedArrivals = 64;

    /// A frame arrived at `at`.
    void arrived(Instant at);
    /// Whether any arrivals judged so far were of two senders.
    bool two_senders() const { return two_senders_; }

  private:
    bool judge() const;
    bool two_with_period(Duration period) const;
    Duration gap(std::size_t arrival) const { return arrivals_[arrival] - arrivals_[arrival - 1]; }

    std::array<Instant, kJudgedArrivals> arrivals_{};
    std::size_t count_ = 0;
    bool two_senders_ = false;
};

}  // namespace tribus
