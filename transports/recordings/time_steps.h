#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "core/time.h"

/// What the times of a recording must be so that they can be played. Pure.
namespace tribus {

/// Tells differences from line to line, as `candump -td` writes them, from times since the first
/// line (`candump -tz`). Both have three digits of seconds, `(000.010012)`; since 1970 there are
/// ten. Differences go down as far as they go up.
class DifferenceWatch {
  public:
    /// Takes the time of the next line, and its number of digits before the point.
    void take(std::size_t digits, Duration time);

    /// Whether the lines so far can only be differences.
    bool certain() const;
    /// The same at the end of the recording, when no more lines will come.
    bool probable() const;
    /// Whether the recording has short times, which may be differences.
    bool possible() const { return possible_; }

  private:
    bool possible_ = false;
    std::size_t lines_ = 0;
    Duration latest_{};
    /// Sums of the steps after the second line.
    Duration up_{};
    Duration down_{};
};

/// A step of time that nobody wants to run through.
struct TimeGap {
    unsigned line = 0;
    Duration from{};
    Duration to{};
};

/// Upper limit of the time without data in a recording that is played.
inline constexpr Duration kLongestGap = std::chrono::hours(1);

/// Finds the first gap. Thread-bound.
class GapWatch {
  public:
    void take(Duration at, unsigned line);
    /// Between two lines.
    const std::optional<TimeGap>& first() const { return first_; }
    /// Before the first line.
    const std::optional<TimeGap>& late_start() const { return late_start_; }

  private:
    std::optional<Duration> latest_;
    std::optional<TimeGap> first_;
    std::optional<TimeGap> late_start_;
};

/// `file:line:1: text`, for who wants to play the recording.
std::string gap_text(std::string_view file, const TimeGap& gap);
/// The same of a gap before the first line, which is played where the time of a recording counts
/// from its start.
std::string late_start_text(std::string_view file, const TimeGap& gap);

}  // namespace tribus
