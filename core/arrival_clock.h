#pragma once

#include "core/time.h"

namespace tribus {

/// Estimates when the frames of an input arrive: fits a line through the latest arrivals. Pure;
/// thread-bound.
class ArrivalClock {
  public:
    /// A frame arrived at `now`.
    void arrived(Instant now);

    /// Whether any frame has arrived.
    bool ever() const { return ever_; }
    /// Arrival of the latest frame. Valid only if `ever`.
    Instant latest() const { return latest_; }
    /// Period of the fitted line; zero before the second arrival.
    Duration interval() const { return interval_; }
    /// Arrival of the latest frame on the fitted line: its arrival without jitter.
    Instant fitted() const { return fitted_; }
    /// How far behind the line a late frame arrives. About one frame in twenty is later.
    Duration lateness() const { return lateness_; }

  private:
    bool period_has_changed(Duration delta);
    void restart_line(Instant now);
    void extend_line(Instant now);

    Instant latest_{};
    bool ever_ = false;
    Duration interval_{};
    Instant fitted_{};
    Duration lateness_{};
    int weighed_ = 0;  ///< arrivals that the line weighs

    Duration latest_delta_{};
    int outliers_ = 0;        ///< in a row: not one interval after the frame before
    int steady_misfits_ = 0;  ///< in a row: same time after the frame before, but no whole number
                              ///< of intervals
    int far_off_ = 0;         ///< in a row: more than a quarter of an interval off the line
    Duration off_by_{};       ///< error of the latest frame if beyond jitter, else zero
};

}  // namespace tribus
