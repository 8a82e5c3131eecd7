#pragma once

#include "core/time.h"

/// What lines show over time. Time is an argument.
namespace tribus {

/// A lamp that blinks is on for so long, then off for so long: 2 Hz, which catches the eye.
inline constexpr Duration kBlinkHalf = std::chrono::milliseconds(250);

/// All lamps blink together.
inline bool blink_is_on(Instant now) {
    return now.time_since_epoch() / kBlinkHalf % 2 == 0;
}
inline Instant next_blink(Instant now) {
    return Instant((now.time_since_epoch() / kBlinkHalf + 1) * kBlinkHalf);
}

/// The square wave of a line with the role `fresh`. It turns every half period, and only if fresh
/// data went out since it last turned and within the half period before: whatever stands still,
/// hangs or is late leaves the line at its level. Thread-bound.
class FreshWave {
  public:
    FreshWave(Duration period, Instant start)
        : half_(period / 2), turned_at_(start), next_(later(start, half_)) {}

    /// When to call `turn`.
    Instant next() const { return next_; }
    /// At `next` or later; `fresh_at` is when each of the watched outputs had written fresh data
    /// at the latest, the oldest of them. Returns whether the line turns. Half periods that were
    /// slept through are lost: no burst of edges makes up for them.
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
