#include "core/schedule.h"

#include <algorithm>
#include <utility>

namespace tribus {
namespace {

/// Least distance of a locked grid behind the arrivals: time for the wake-up that reads them.
constexpr Duration kLeastGuard = std::chrono::microseconds(50);
/// Distance behind the guard that is not worth a longer step to improve.
constexpr Duration kGoodOffset = std::chrono::microseconds(300);
/// Share of a late offset that one period corrects. An early offset is corrected at once: the frame
/// was not there yet, so the values were a whole interval old.
constexpr int kCorrectionShare = 16;
/// Share of an interval for which a point of a locked grid waits for a late frame.
constexpr int kFrameWaitShare = 16;
/// Slowest input, in periods of the output, that the schedule waits for. A slower one is two frames
/// with a long silence between them, or a bus with little traffic.
constexpr int kSlowestInput = 2;
/// If more frames than this are missing, the arrivals do not predict the next one.
constexpr int kMostMissingFrames = 3;
/// If this many frames in a row had to wait, it is no coincidence.
constexpr int kHeldUpInARow = 8;
/// How long a repeat waits beyond the time at which its frame should have come: a tick of the
/// kernel (CONFIG_HZ of 250), and a rest for frames that come a little late. A frame that comes in
/// time then finds the timer of the repeat behind the next tick, so the kernel cancels it without
/// programming the clock.
constexpr Duration kRepeatPatience = std::chrono::microseconds(4500);
/// A sender whose clock is fast by less than this share still has the requested period.
constexpr int kClockTolerance = 100;

}  // namespace

void Schedule::start(Instant now) {
    point_ = now;
    due_ = settings_.kind == ScheduleKind::grid ? now : later(now, settings_.period);
}

void Schedule::frame_arrived(const ArrivalClock& arrivals) {
    arrivals_ = arrivals.line();
    if (settings_.kind == ScheduleKind::follow) {
        due_ = follow_due();
    } else if (locked_step()) {
        due_ = locked_due();
    }
}

void Schedule::continue_from(const Schedule& before, Instant now) {
    const ScheduleSettings settings = std::exchange(settings_, before.settings_);
    *this = before;
    settings_ = settings;
    set_period(settings.period);
    const Instant at_most =
        later(before.latest_write_ == kLongAgo ? now : before.latest_write_, settings.period);
    due_ = std::max(now, std::min(before.due_, at_most));
    // A grid that begins here must not count earlier time as missed.
    point_ = due_;
}

[[gnu::cold]] void Schedule::retime(Duration period, Duration later) {
    set_period(period);
    if (settings_.kind == ScheduleKind::grid && settings_.phase == Phase::free &&
        served_point_ != kLongAgo) {
        point_ = served_point_ + std::clamp(period + later, period / 2, 2 * period);
        due_ = point_;
    }
}

/// The turn of the frame that is written next.
Instant Schedule::turn_of_next() const {
    return std::max(turn_ + settings_.period, arrivals_.fitted);
}

/// A frame that must wait because another was written shortly before delays the next frame too, and
/// that one the next. If the next frame is nearly there, it is sent instead. The same happens after
/// a run of frames that had to wait, as after a stall where both periods are equal.
Instant Schedule::follow_due() const {
    const Instant latest = arrivals_.latest;
    const Instant due = std::max({latest, turn_ + settings_.period, latest_write_ + spacing_});
    if (due == latest) {
        return due;
    }
    const Duration interval = arrivals_.interval;
    const Instant next = arrivals_.fitted + interval;
    const bool holds_up_next =
        due < next && std::max(turn_of_next() + settings_.period, due + spacing_) > next;
    if (!holds_up_next || (next - due >= interval / 2 && held_up_ < kHeldUpInARow)) {
        return due;
    }
    const Instant patient =
        std::min(expected_by(1), latest_write_ + 2 * settings_.period) + kRepeatPatience;
    return std::min(patient, std::max(due, valid_until_));
}

/// When the frame that comes `frames` frames after the latest one should have arrived, even if
/// it is late.
Instant Schedule::expected_by(int frames) const {
    return arrivals_.fitted + frames * arrivals_.interval + 2 * arrivals_.lateness + kLeastGuard;
}

/// A period has passed without a new frame, but a frame that is about to arrive is worth waiting
/// for: with 7.7 ms from the receiver and 7 ms here, a repeat would delay every fresh frame.
Instant Schedule::repeat_due(Instant now) const {
    const Instant planned = now + settings_.period;
    if (arrivals_.interval <= Duration::zero()) {
        return planned;
    }
    Instant expected = expected_by(1);
    for (int frames = 2; expected <= planned && frames <= kMostMissingFrames; ++frames) {
        expected += arrivals_.interval;
    }
    const bool soon = expected > planned && expected < planned + settings_.period;
    return soon ? expected + kRepeatPatience : planned;
}

Duration Schedule::least_step() const {
    return settings_.period - settings_.period / kClockTolerance;
}

/// A whole number of input intervals, so that every point of the grid finds a frame of the same
/// age. Nothing if the input has no period yet, is slow, or has stopped.
std::optional<Duration> Schedule::locked_step() const {
    const Duration interval = arrivals_.interval;
    if (settings_.phase == Phase::free || interval <= Duration::zero() ||
        interval > kSlowestInput * settings_.period ||
        point_ > arrivals_.latest + 2 * (settings_.period + interval)) {
        return std::nullopt;
    }
    return (least_step() + interval - Duration(1)) / interval * interval;
}

/// How far to move the planned point so that it ends up just behind the arrivals: back towards the
/// arrival before it if the period leaves room for a shorter step, else on to the next one.
Duration Schedule::correction(Instant planned, Duration step) const {
    const Duration interval = arrivals_.interval;
    const Duration guard = std::max(kLeastGuard, arrivals_.lateness);
    const Duration behind = planned - guard - arrivals_.fitted;
    const Duration late = (behind % interval + interval) % interval;
    const Duration slack = std::max(step - settings_.period, Duration::zero());
    if (late < kGoodOffset || (late <= interval / 2 && slack > Duration::zero())) {
        return -std::min(late / kCorrectionShare, slack);
    }
    return interval - late;
}

/// A point waits briefly for its frame. Without it, the values would be a whole interval older.
Instant Schedule::locked_due() const {
    const Duration interval = arrivals_.interval;
    const bool frame_is_there = arrivals_.latest >= point_ - interval / 2;
    const Instant due =
        frame_is_there ? std::max(point_, arrivals_.latest) : point_ + interval / kFrameWaitShare;
    return std::max(due, latest_write_ + least_step());
}

void Schedule::done(Instant now, bool wrote, Instant valid_until) {
    if (wrote) {
        turn_ = std::clamp(turn_of_next(), now - settings_.period, now);
        latest_write_ = now;
    }
    if (settings_.kind == ScheduleKind::grid) {
        grid_done(now);
        return;
    }
    if (now - due_ >= settings_.period) {
        overruns_ += static_cast<std::uint64_t>((now - due_) / settings_.period);
    }
    const bool waited = due_ > arrivals_.latest + kGoodOffset;
    held_up_ = waited ? std::min(held_up_ + 1, kHeldUpInARow) : 0;
    valid_until_ = valid_until;
    due_ = std::min(repeat_due(now), std::max(valid_until, now + settings_.period));
}

void Schedule::grid_done(Instant now) {
    const Instant served = due_;
    const std::optional<Duration> locked = locked_step();
    const Duration step = locked.value_or(settings_.period);
    served_point_ = point_;
    point_ += step;
    if (point_ <= now) {
        const auto missed = (now - point_) / step + 1;
        overruns_ += static_cast<std::uint64_t>(missed);
        point_ += missed * step;
    }
    if (locked) {
        point_ += correction(point_, step);
    }
    if (locked_step()) {
        due_ = locked_due();
        return;
    }
    // When a grid is no longer locked, it continues from the point that was served late.
    if (settings_.phase == Phase::locked) {
        point_ = std::max(point_, served + settings_.period);
    }
    due_ = point_;
}

}  // namespace tribus
