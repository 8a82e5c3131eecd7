#pragma once

#include <cstdint>
#include <optional>

#include "core/arrival_clock.h"
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

    bool operator==(const ScheduleSettings&) const = default;
};

/// Decides when an output is due. Pure arithmetic on absolute instants; thread-bound.
class Schedule {
  public:
    explicit Schedule(const ScheduleSettings& settings) : settings_(settings) {}

    /// Sets the first deadline: `grid` at once, `follow` after a period without a first frame.
    void start(Instant now);

    /// An input frame that this output should carry arrived, the latest that `arrivals` knows.
    void frame_arrived(const ArrivalClock& arrivals);

    /// Goes on at `now` as `before`, by its own settings: the next deadline stays, unless a shorter
    /// period asks for an earlier one.
    void continue_from(const Schedule& before, Instant now);

    /// From the next deadline on.
    void set_period(Duration period) { settings_.period = period; }

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
