#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

#include "core/time.h"

namespace tribus {

/// Debounces a contact: a new level counts after it was stable for the given time. After an edge
/// the line may be left alone for that time, at least 1 ms. Time is an argument. Thread-bound.
class Debouncer {
  public:
    /// `still`: time for which a new level must be stable. Zero: no debouncing.
    explicit Debouncer(Duration still) : still_(still) {}

    /// Takes the level at `now`. `nullopt` means that the line cannot be read; that, and the first
    /// level after it, count at once. `edge`: the latest edge since the call before.
    void look(std::optional<bool> level, std::optional<Instant> edge, Instant now) {
        const Instant still_at = edge ? later(*edge, still_) : settles_at_;
        if (edge) {
            rests_until_ = std::max(still_at, now + kLeastRest);
        }
        const bool counts_at_once = !level || !level_ || still_ == Duration::zero();
        if (counts_at_once || now >= still_at || level == level_) {
            level_ = level;
            settles_at_ = kNever;
        } else if (edge) {
            settles_at_ = rests_until_;
        } else if (settles_at_ == kNever) {
            settles_at_ = later(now, still_);
        }
    }

    /// `nullopt` while the line cannot be read, and before the first call of `look`.
    std::optional<bool> level() const { return level_; }
    /// When to call `look` next if the line has no edge before. `kNever` if the level is stable.
    Instant settles_at() const { return settles_at_; }
    /// Before this instant an edge need not wake anybody: a line that bounces or picks up noise
    /// would take all the time of a processor.
    Instant rests_until() const { return rests_until_; }

  private:
    static constexpr Duration kLeastRest = std::chrono::milliseconds(1);

    Duration still_;
    std::optional<bool> level_;
    Instant settles_at_ = kNever;
    Instant rests_until_{};
};

}  // namespace tribus
