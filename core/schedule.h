#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "core/arrival_clock.h"
#include "core/time.h"

namespace tribus {

/// When an output sends.
enum class ScheduleKind : std::uint8_t {
    follow,  ///< with each new frame, at most once per period; once per period without one
    grid,    ///< at points of its own, whether or not a frame arrives
};

/// How a grid relates to the arrivals of the input.
enum class Phase : std::uint8_t {
    free,  ///< the points are a period apart
    /// The grid is steered to stay just behind the arrivals of the input. The points are the least
    /// number of whole intervals of the input apart that is not shorter than the period.
    locked,
};

struct ScheduleSettings {
    ScheduleKind kind = ScheduleKind::follow;
    Duration period = std::chrono::milliseconds(14);
    Phase phase = Phase::free;
    /// Least time from one frame to the next where the first one was late or is a repeat: readers
    /// of the protocol take both. By default, and at most, the period. Only for `follow`.
    Duration least_spacing = Duration::max();

    bool operator==(const ScheduleSettings&) const = default;
};

/// Decides when an output is due. Absolute instants, no clock. Pure; thread-bound.
class Schedule {
  public:
    explicit Schedule(const ScheduleSettings& settings) : settings_(settings) {
        set_period(settings.period);
    }

    /// Sets the first deadline: a `grid` is due at once, `follow` one period later if no frame
    /// arrives.
    void start(Instant now);

    /// A frame for this output arrived: the latest one of `arrivals`.
    void frame_arrived(const ArrivalClock& arrivals);

    /// Continues at `now` where `before` stands, with its own settings. Keeps the next deadline
    /// unless a shorter period requires an earlier one.
    void continue_from(const Schedule& before, Instant now);

    /// Takes effect with the next deadline.
    void set_period(Duration period) {
        settings_.period = period;
        spacing_ = std::min(settings_.least_spacing, period);
    }

    /// A receiver of the frames asks for this period, and for the next point of a free grid that
    /// much `later` than a period after the one before. A step is at least half a period and at
    /// most two.
    void retime(Duration period, Duration later);

    /// A receiver of the frames asks for one at `now`, wherever the next point of a free grid is.
    void due_at_once(Instant now) {
        point_ = now;
        due_ = now;
    }

    /// When the output is due next.
    Instant due() const { return due_; }

    /// Sets the next deadline. Call at `now`, not before `due()`; `wrote` is false if the output
    /// sent nothing. A grid stays on its points: missed whole periods are skipped and counted.
    /// `valid_until`: what was written is true until then. No later frame waits beyond that for the
    /// one behind it.
    void done(Instant now, bool wrote, Instant valid_until = kNever);

    /// Whole periods that were missed because `done` was called late.
    std::uint64_t overruns() const { return overruns_; }
    Duration period() const { return settings_.period; }

  private:
    Instant follow_due() const;
    Instant expected_by(int frames) const;
    Instant repeat_due(Instant now) const;
    Instant turn_of_next() const;
    Duration least_step() const;
    std::optional<Duration> locked_step() const;
    Duration correction(Instant planned, Duration step) const;
    Instant locked_due() const;
    void grid_done(Instant now);

    /// Sums with durations do not overflow.
    static constexpr Instant kLongAgo = Instant(Duration::min() / 2);

    ScheduleSettings settings_;
    Duration spacing_{};  ///< least spacing with the present period
    Instant due_ = kNever;
    /// The latest point of the grid. Nothing is written before it.
    Instant point_ = kNever;
    /// Before all time if nothing was written.
    Instant latest_write_ = kLongAgo;
    /// When the latest frame would have been written if neither it nor a repeat had been late. The
    /// next frame's turn is a period later.
    Instant turn_ = kLongAgo;
    /// What was written latest is true until then.
    Instant valid_until_ = kNever;
    /// Frames in a row that were written well after their arrival.
    int held_up_ = 0;
    ArrivalLine arrivals_;
    std::uint64_t overruns_ = 0;
    /// The latest point of a grid that was served. Before all time if there is none.
    Instant served_point_ = kLongAgo;
};

}  // namespace tribus
