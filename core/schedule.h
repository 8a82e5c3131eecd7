#pragma once

#include <cstdint>
#include <optional>

#include "core/time.h"

namespace tribus {

enum class ScheduleKind : std::uint8_t {
    follow,  ///< send when a new frame arrives, at most once a period, and once a period without
    grid,    ///< strictly periodic, whatever arrives
};

enum class Phase : std::uint8_t {
    free,
    locked,  ///< the grid is steered to stand just behind the input's arrival
};

struct ScheduleSettings {
    ScheduleKind kind = ScheduleKind::follow;
    Duration period = std::chrono::milliseconds(14);
    Phase phase = Phase::free;
};

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
    bool has_another_period(Duration delta);
    void begin_rhythm(Instant now);
    void follow_rhythm(Instant now);

    Instant latest_{};
    Duration interval_{};
    Duration latest_delta_{};
    int outliers_ = 0;
    int steady_misfits_ = 0;
    bool ever_ = false;
    Instant rhythm_{};
    Duration lateness_{};
    int off_beat_ = 0;
    Duration off_by_{};
    int remembered_ = 0;
};

/// Decides when an output is due. Pure arithmetic on absolute instants; thread-bound.
class Schedule {
  public:
    explicit Schedule(const ScheduleSettings& settings) : settings_(settings) {}

    /// Sets the first deadline: `grid` at once, `follow` after a period without a first frame.
    void start(Instant now);

    /// An input frame that this output should carry arrived, the latest that `arrivals` knows.
    void frame_arrived(const ArrivalClock& arrivals);

    /// When the output is due next.
    Instant due() const { return due_; }

    /// The output had its turn at `now`, which is not before `due()`; `wrote` unless it is silent.
    /// Sets the next deadline: never `now` plus the period on a grid, whose whole missed periods
    /// are skipped and counted.
    void done(Instant now, bool wrote);

    std::uint64_t overruns() const { return overruns_; }
    Duration period() const { return settings_.period; }

  private:
    Instant follow_due() const;
    Instant expected_by(int beats) const;
    Instant repeat_due(Instant now) const;
    Duration least_step() const;
    std::optional<Duration> locked_step() const;
    Duration steering(Instant planned, Duration step) const;
    Instant locked_due() const;

    ScheduleSettings settings_;
    Instant due_ = kNever;
    /// The latest point of the grid, which is not written before.
    Instant point_ = kNever;
    std::optional<Instant> latest_write_;
    /// Frames in a row that were written well behind their arrival.
    int held_up_ = 0;
    ArrivalClock arrivals_;
    std::uint64_t overruns_ = 0;
};

}  // namespace tribus
