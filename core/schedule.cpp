#include "core/schedule.h"

#include <algorithm>

namespace tribus {
namespace {

/// Weight of a new interval in the smoothed one: forgets in about 16 frames.
constexpr int kSmoothing = 16;
/// So many intervals in a row that do not fit mean that the sender has changed its period.
constexpr int kOutliersToRestart = 4;
/// How far behind an arrival a locked grid stands: room for the arrival's own jitter.
constexpr Duration kLockedGuard = std::chrono::microseconds(300);
/// Share of a late stand that one period takes back. An early one is put right at once: the frame
/// was not there yet, so the values were a whole interval old. So the grid comes to stand behind
/// the latest of arrivals that jitter.
constexpr int kSteering = 32;
/// A sender whose clock runs fast by so little still counts as having the period asked for.
constexpr int kClockTolerance = 100;

}  // namespace

void ArrivalClock::arrived(Instant now) {
    const Duration delta = now - latest_;
    const bool first = !ever_;
    latest_ = now;
    ever_ = true;
    if (first) {
        return;
    }
    const bool fits = delta > interval_ / 2 && delta < interval_ + interval_ / 2;
    if (interval_ == Duration::zero() || (!fits && ++outliers_ >= kOutliersToRestart)) {
        interval_ = delta;
        outliers_ = 0;
    } else if (fits) {
        interval_ += (delta - interval_) / kSmoothing;
        outliers_ = 0;
    }
}

void Schedule::start(Instant now) {
    due_ = settings_.kind == ScheduleKind::grid ? now : later(now, settings_.period);
}

void Schedule::frame_arrived(const ArrivalClock& arrivals) {
    arrivals_ = arrivals;
    if (settings_.kind == ScheduleKind::follow) {
        due_ = latest_write_ ? std::max(arrivals.latest(), *latest_write_ + settings_.period)
                             : arrivals.latest();
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

/// A whole number of input intervals, so that each point of the grid finds a frame equally old;
/// nothing while the input has no rhythm or has stopped.
std::optional<Duration> Schedule::locked_step() const {
    const Duration interval = arrivals_.interval();
    if (settings_.phase == Phase::free || interval <= Duration::zero() ||
        due_ > arrivals_.latest() + 2 * (settings_.period + interval)) {
        return std::nullopt;
    }
    const Duration least = settings_.period - settings_.period / kClockTolerance;
    return (least + interval - Duration(1)) / interval * interval;
}

/// How far to move the planned point so that it comes to stand just behind an arrival: back to the
/// one before it where the period leaves room for a shorter step, else on to the next.
Duration Schedule::steering(Instant planned, Duration step) const {
    const Duration interval = arrivals_.interval();
    const Duration behind = planned - kLockedGuard - arrivals_.latest();
    const Duration late = (behind % interval + interval) % interval;
    const Duration slack = std::max(step - settings_.period, Duration::zero());
    if (late < kLockedGuard || (late <= interval / 2 && slack > Duration::zero())) {
        return -std::min(late / kSteering, slack);
    }
    return interval - late;
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
    due_ += step;
    if (due_ <= now) {
        const auto missed = (now - due_) / step + 1;
        overruns_ += static_cast<std::uint64_t>(missed);
        due_ += missed * step;
    }
    if (locked) {
        due_ += steering(due_, step);
    }
}

}  // namespace tribus
