#pragma once

#include "core/time.h"

namespace tribus {

/// When frames of an input arrive, as far as the past tells. Pure; thread-bound.
class ArrivalClock {
  public:
    void arrived(Instant now);

    bool ever() const { return ever_; }
    Instant latest() const { return latest_; }
    /// Time between two frames, by the line through the latest arrivals; zero before the second.
    Duration interval() const { return interval_; }
    /// When the latest frame was due by the rhythm of those before it: its arrival without jitter.
    Instant rhythm() const { return rhythm_; }
    /// How long behind its place in the rhythm a late frame comes; about one in twenty comes later.
    Duration lateness() const { return lateness_; }

  private:
    bool period_has_changed(Duration delta);
    void begin_rhythm(Instant now);
    void follow_rhythm(Instant now);

    Instant latest_{};
    bool ever_ = false;
    Duration interval_{};
    Instant rhythm_{};
    Duration lateness_{};
    int remembered_ = 0;  ///< arrivals that the line goes through

    Duration latest_delta_{};
    int outliers_ = 0;        ///< in a row: not after an interval
    int steady_misfits_ = 0;  ///< in a row: after the same time, but not after whole intervals
    int off_beat_ = 0;        ///< in a row: far from their place in the rhythm
    Duration off_by_{};       ///< by which the latest one missed it, if beyond jitter
};

}  // namespace tribus
