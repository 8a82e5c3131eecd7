#pragma once

#include <optional>

#include "core/time.h"

namespace tribus {

/// Makes a level of a contact that bounces: a new one counts once it has stood still for a while.
/// Time is an argument. Thread-bound.
class Debouncer {
  public:
    explicit Debouncer(Duration still) : still_(still) {}

    /// The line reads `level` at `now`; nothing: it cannot be read, which counts at once, as does
    /// the first level behind it. `moved`: it had edges since the look before, seen or not.
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

    /// Nothing while the line cannot be read, and before the first look.
    std::optional<bool> level() const { return level_; }
    /// When to look next although nothing moves; `kNever`: the level has settled.
    Instant settles_at() const { return settles_at_; }

  private:
    Duration still_;
    std::optional<bool> level_;
    Instant settles_at_ = kNever;
};

}  // namespace tribus
