#pragma once

#include <optional>

#include "core/time.h"

namespace tribus {

/// Debounces a contact: a new level counts after it was stable for the given time. Time is an
/// argument. Thread-bound.
class Debouncer {
  public:
    /// `still`: time for which a new level must be stable. Zero: no debouncing.
    explicit Debouncer(Duration still) : still_(still) {}

    /// Takes the level at `now`. `nullopt` means that the line cannot be read; that, and the first
    /// level after it, count at once. `moved`: the line had edges since the call before.
    void look(std::optional<bool> level, bool moved, Instant now) {
        const bool counts_at_once = !level || !level_ || still_ == Duration::zero();
        const bool stood_still = !moved && now >= settles_at_;
        if (counts_at_once || stood_still || level == level_) {
            level_ = level;
            settles_at_ = kNever;
        } else if (moved || settles_at_ == kNever) {
            settles_at_ = later(now, still_);
        }
    }

    /// `nullopt` while the line cannot be read, and before the first call of `look`.
    std::optional<bool> level() const { return level_; }
    /// When to call `look` next if the line has no edge before. `kNever` if the level is stable.
    Instant settles_at() const { return settles_at_; }

  private:
    Duration still_;
    std::optional<bool> level_;
    Instant settles_at_ = kNever;
};

}  // namespace tribus
