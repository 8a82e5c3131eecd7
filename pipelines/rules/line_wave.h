#pragma once

#include "core/time.h"

/// What output lines show over time. Time is an argument.
namespace tribus {

/// Half period of a blinking lamp: 2 Hz.
inline constexpr Duration kBlinkHalf = std::chrono::milliseconds(250);

/// All lamps blink in phase.
inline bool blink_is_on(Instant now) {
    return now.time_since_epoch() / kBlinkHalf % 2 == 0;
}
/// When the lamps change next.
inline Instant next_blink(Instant now) {
    return Instant((now.time_since_epoch() / kBlinkHalf + 1) * kBlinkHalf);
}

/// The square wave of a line with the role `fresh`. It toggles every half period, but only if fresh
/// data was sent since it last toggled and within the last half period. Otherwise the line keeps
/// its level. Thread-bound.
class FreshWave {
  public:
    FreshWave(Duration period, Instant start)
        : half_(period / 2), turned_at_(start), next_(later(start, half_)) {}

    /// When to call `turn` next.
    Instant next() const { return next_; }
    /// Call at `next` or later. `fresh_at`: for each watched output the time of its latest fresh
    /// data; the oldest of these times. Returns whether the line toggles. Missed half periods are
    /// skipped, not made up for.
    bool turn(Instant fresh_at, Instant now) {
        const bool turns = fresh_at > turned_at_ && now - fresh_at <= half_;
        if (turns) {
            active_ = !active_;
            turned_at_ = now;
        }
        next_ += ((now - next_) / half_ + 1) * half_;
        return turns;
    }
    bool active() const { return active_; }

  private:
    Duration half_;
    Instant turned_at_;
    Instant next_;
    bool active_ = false;
};

}  // namespace tribus
