#pragma once

#include "core/time.h"

namespace tribus {

/// A line through the latest arrivals of an input, and the latest of them.
struct ArrivalLine {
    /// Valid only after the first arrival.
    Instant latest{};
    /// Arrival of the latest frame on the line: its arrival without jitter.
    Instant fitted{};
    /// Period of the line; zero before the second arrival.
    Duration interval{};
    /// How far behind the line a late frame arrives. About one frame in twenty is later.
    Duration lateness{};
};

/// Estimates when the frames of an input arrive: fits a line through the latest arrivals. Pure;
/// thread-bound.
class ArrivalClock {
  public:
    /// A frame arrived at `now`.
    void arrived(Instant now);

    /// Whether any frame has arrived.
    bool ever() const { return ever_; }
    const ArrivalLine& line() const { return line_; }
    Instant latest() const { return line_.latest; }
    Duration interval() const { return line_.interval; }
    Instant fitted() const { return line_.fitted; }
    Duration lateness() const { return line_.lateness; }

  private:
    bool continues_line(Instant now, Duration delta);
    bool period_has_changed(Duration delta);
    void restart_line(Instant now);
    void extend_line(Instant now);
    void follow(Duration error);

    ArrivalLine line_;
    bool ever_ = false;
    int weighed_ = 0;  ///< arrivals that the line weighs

    Duration latest_delta_{};
    int outliers_ = 0;        ///< in a row: not one interval after the frame before
    int steady_misfits_ = 0;  ///< in a row: same time after the frame before, but no whole number
                              ///< of intervals
    int far_off_ = 0;         ///< in a row: more than a quarter of an interval off the line
    Duration off_by_{};       ///< error of the latest frame if beyond jitter, else zero
};

}  // namespace tribus
