#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/time.h"

namespace tribus {

/// Judges by the arrivals of one CAN id alone whether two nodes send it, each in its own rhythm: so
/// long after many frames comes the next one, and for some of these another frame stands between.
/// Says nothing of two senders that keep a half, third or quarter of a period apart, which look
/// like a quicker one, of one that is ten times as rare as the other, and of senders that jitter by
/// more than a few percent: it may miss two senders, but calls no single one two, unless that sends
/// in pairs. Pure and thread-bound; no heap.
class RhythmWatch {
  public:
    /// Judged all together, then the next ones.
    static constexpr std::size_t kJudgedArrivals = 64;

    void arrived(Instant at);
    /// The latest arrivals that were judged, or any before them, were of two senders.
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
