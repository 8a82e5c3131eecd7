#include "core/schedule.h"

#include <algorithm>

namespace tribus {
namespace {

/// Weight of a new interval in the smoothed one: forgets in about 16 frames.
constexpr int kSmoothing = 16;
/// So many intervals in a row that do not fit mean that the sender has changed its period. Lost
/// frames make intervals longer, never shorter, so for longer ones more have to agree.
constexpr int kOutliersToRestart = 4;
constexpr int kLongOutliersToRestart = 16;
/// How fast the lateness of frames is believed, half of it but no more than this share of an
/// interval, so that a single stall of the machine counts little; and how fast it is forgotten.
constexpr int kLatenessRise = 2;
constexpr int kLatenessStep = 64;
constexpr int kLatenessDecay = 128;
/// Share of an interval beyond which an error says more of the machine than of the sender.
constexpr int kMostError = 16;

/// How far behind the arrivals a locked grid stands at least: room for the wake that reads them.
constexpr Duration kLeastGuard = std::chrono::microseconds(50);
/// A stand behind the guard that need not be improved where that would cost a longer step.
constexpr Duration kStandsWell = std::chrono::microseconds(300);
/// Share of a late stand that one period takes back. An early one is put right at once: the frame
/// was not there yet, so the values were a whole interval old.
constexpr int kSteering = 16;
/// Share of an interval for which a point of a locked grid waits for a frame that is late.
constexpr int kPatience = 16;
/// A sender whose clock runs fast by so little still counts as having the period asked for.
constexpr int kClockTolerance = 100;

}  // namespace

void ArrivalClock::arrived(Instant now) {
    const Duration delta = now - latest_;
    const bool first = !ever_;
    latest_ = now;
    ever_ = true;
    if (first) {
        rhythm_ = now;
        return;
    }
    const bool fits = delta > interval_ / 2 && delta < interval_ + interval_ / 2;
    const int outliers_to_restart = delta > interval_ ? kLongOutliersToRestart : kOutliersToRestart;
    if (interval_ == Duration::zero() || (!fits && ++outliers_ >= outliers_to_restart)) {
        interval_ = delta;
        outliers_ = 0;
    } else if (fits) {
        interval_ += without_stall(delta - interval_) / kSmoothing;
        outliers_ = 0;
    }
    follow_rhythm(now);
}

Duration ArrivalClock::without_stall(Duration error) const {
    const Duration most = interval_ / kMostError;
    return std::clamp(error, -most, most);
}

void ArrivalClock::follow_rhythm(Instant now) {
    if (interval_ <= Duration::zero()) {
        rhythm_ = now;
        return;
    }
    const auto beats = std::max<std::int64_t>((now - rhythm_ + interval_ / 2) / interval_, 1);
    const Instant beat = rhythm_ + beats * interval_;
    const Duration error = now - beat;
    const bool on_beat = std::chrono::abs(error) < interval_ / 4;
    off_beat_ = on_beat ? 0 : off_beat_ + 1;
    if (off_beat_ >= kOutliersToRestart) {
        rhythm_ = now;
        lateness_ = Duration::zero();
        off_beat_ = 0;
        return;
    }
    rhythm_ = beat + without_stall(error) / kSmoothing;
    lateness_ += error > lateness_
                     ? std::min((error - lateness_) / kLatenessRise, interval_ / kLatenessStep)
                     : -lateness_ / kLatenessDecay;
}

void Schedule::start(Instant now) {
    point_ = now;
    due_ = settings_.kind == ScheduleKind::grid ? now : later(now, settings_.period);
}

void Schedule::frame_arrived(const ArrivalClock& arrivals) {
    arrivals_ = arrivals;
    if (settings_.kind == ScheduleKind::follow) {
        due_ = latest_write_ ? std::max(arrivals.latest(), *latest_write_ + settings_.period)
                             : arrivals.latest();
    } else if (locked_step()) {
        due_ = locked_due();
    }
}

/// A period without a new frame has passed; but a frame that is just about due is worth waiting
/// for: at 7.7 ms from the receiver and 7 ms here, a repeat would push each fresh frame back.
Instant Schedule::repeat_due(Instant now) const {
    const Instant planned = now + settings_.period;
    const Instant expected = arrivals_.next_expected_by();
    const bool worth_waiting = arrivals_.interval() > Duration::zero() && expected > planned &&
                               expected < planned + settings_.period;
    return worth_waiting ? expected : planned;
}

Duration Schedule::least_step() const {
    return settings_.period - settings_.period / kClockTolerance;
}

/// A whole number of input intervals, so that each point of the grid finds a frame equally old;
/// nothing while the input has no rhythm or has stopped.
std::optional<Duration> Schedule::locked_step() const {
    const Duration interval = arrivals_.interval();
    if (settings_.phase == Phase::free || interval <= Duration::zero() ||
        point_ > arrivals_.latest() + 2 * (settings_.period + interval)) {
        return std::nullopt;
    }
    return (least_step() + interval - Duration(1)) / interval * interval;
}

/// How far to move the planned point so that it comes to stand just behind the arrivals: back to
/// the one before it where the period leaves room for a shorter step, else on to the next.
Duration Schedule::steering(Instant planned, Duration step) const {
    const Duration interval = arrivals_.interval();
    const Duration guard = std::max(kLeastGuard, arrivals_.lateness());
    const Duration behind = planned - guard - arrivals_.rhythm();
    const Duration late = (behind % interval + interval) % interval;
    const Duration slack = std::max(step - settings_.period, Duration::zero());
    if (late < kStandsWell || (late <= interval / 2 && slack > Duration::zero())) {
        return -std::min(late / kSteering, slack);
    }
    return interval - late;
}

/// A point waits a moment for the frame that belongs to it: sent without, the values would be a
/// whole interval older.
Instant Schedule::locked_due() const {
    const Duration interval = arrivals_.interval();
    const bool frame_is_there = arrivals_.latest() >= point_ - interval / 2;
    const Instant due =
        frame_is_there ? std::max(point_, arrivals_.latest()) : point_ + interval / kPatience;
    return latest_write_ ? std::max(due, *latest_write_ + least_step()) : due;
}

void Schedule::done(Instant now, bool wrote) {
    if (wrote) {
        latest_write_ = now;
    }
    if (settings_.kind == ScheduleKind::follow) {
        overruns_ += static_cast<std::uint64_t>((now - due_) / settings_.period);
        due_ = repeat_due(now);
        return;
    }
    const std::optional<Duration> locked = locked_step();
    const Duration step = locked.value_or(settings_.period);
    point_ += step;
    if (point_ <= now) {
        const auto missed = (now - point_) / step + 1;
        overruns_ += static_cast<std::uint64_t>(missed);
        point_ += missed * step;
    }
    if (locked) {
        point_ += steering(point_, step);
    }
    due_ = locked_step() ? locked_due() : point_;
}

}  // namespace tribus
