#include "pipelines/engine/output.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace tribus {
namespace {

/// Longer than the period of any sender that a reader would confuse with this output.
constexpr Duration kForeignSenderMemory = std::chrono::seconds(1);
/// Fewer frames are no second sender: they may be left over in the controller from a program that
/// has just ended, or come from a test. Readers of a protected format reject them.
constexpr int kForeignSenderFrames = 3;
/// Number of busy frames in a row after which the port counts as obstructed.
constexpr int kBusyFrames = 10;

}  // namespace

Output::Output(OutputSettings settings)
    : name_(std::move(settings.name)),
      encoder_(std::move(settings.encoder)),
      yield_to_foreign_sender_(settings.yield_to_foreign_sender),
      schedule_(settings.schedule),
      selector_(settings.selection, settings.failsafe.recover, settings.failsafe.power_on),
      changeover_us_per_second_(settings.selection.changeover_us_per_second),
      map_(settings.channels),
      mapped_channels_(settings.mapped_channels),
      failsafe_(settings.failsafe) {}

void Output::frame_arrived(std::size_t index, const ArrivalClock& arrivals) {
    const bool standby = stage_ == OutputStage::control && index != selector_.current();
    if (!standby) {
        schedule_.frame_arrived(arrivals);
    }
}

void Output::end(Instant now) {
    ending_ = true;
    stage_ = OutputStage::failsafe;
    glide_.stop();
    schedule_.start(now);
}

void Output::foreign_frame_seen(Instant now) {
    ++counts_.foreign_frames;
    const bool goes_on = foreign_run_ > 0 && now < later(foreign_seen_, kForeignSenderMemory);
    foreign_run_ = goes_on ? std::min(foreign_run_ + 1, kForeignSenderFrames) : 1;
    foreign_seen_ = now;
    if (yield_to_foreign_sender_ && foreign_run_ == kForeignSenderFrames) {
        // `recover` applies afterwards, as after any failsafe. `select` would not enforce it,
        // because the input was never lost.
        yield_until_ = later(later(now, kForeignSenderMemory), failsafe_.recover);
    }
}

void Output::force_failsafe(bool on, Instant now) {
    if (forced_ && !on) {
        yield_until_ = std::max(yield_until_, later(now, failsafe_.recover));
    }
    forced_ = on;
}

bool Output::must_yield(Instant now) const {
    return ending_ || forced_ || now < yield_until_;
}

OutputState Output::state(Instant now) const {
    OutputState state{
        .stage = stage(),
        .obstacle = obstacle_,
        .awaits_release = awaits_release_,
        .forced = must_yield(now),
        .input = selector_.follows_one() ? controlling_input().value_or(kNoInput) : kNoInput,
        .outvoted = 0,
        .marks_frame_lost = encoder_.encoder().marks_frame_lost(),
        .by_preset = by_preset_};
    for (std::size_t place = 0; place < inputs().size(); ++place) {
        state.outvoted |= selector_.outvoted(place) ? 1U << place : 0U;
    }
    return state;
}

std::optional<std::size_t> Output::controlling_input() const {
    return stage() == OutputStage::control ? selector_.current() : std::nullopt;
}

void Output::dropped_busy() {
    ++counts_.busy_drops;
    busy_run_ = std::min(busy_run_ + 1, kBusyFrames);
    if (busy_run_ == kBusyFrames) {
        obstacle_ = SendObstacle::busy;
    }
}

void Output::dropped_lost() {
    ++counts_.lost_drops;
    obstacle_ = SendObstacle::device;
}

void Output::dropped_unavailable() {
    ++counts_.unavailable_drops;
    obstacle_ = SendObstacle::bus;
}

void Output::set_device_present(bool present) {
    if (!present) {
        obstacle_ = SendObstacle::device;
    } else if (obstacle_ == SendObstacle::device) {
        obstacle_ = SendObstacle::none;
    }
}

std::optional<ChannelFrame> Output::failsafe_frame(Instant now) {
    ChannelFrame frame;
    switch (failsafe_.action) {
        case FailsafeAction::silence:
            return std::nullopt;
        case FailsafeAction::hold:
            if (!held_) {
                return std::nullopt;
            }
            frame = *held_;
            break;
        case FailsafeAction::preset:
            for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
                frame.set(channel, failsafe_.presets[channel]);
            }
            glide_.apply(frame, now);
            map_.restart_from(frame, now);
            break;
    }
    frame.frame_lost = true;
    frame.failsafe = true;
    return frame;
}

/// Starts at the time of the latest frame, so that already the first frame of the glide moves.
void Output::glide_from_latest(std::optional<double> us_per_second) {
    if (us_per_second && made_frame_) {
        glide_.start(latest_, *us_per_second, latest_at_);
    } else {
        glide_.stop();
    }
}

/// The frame of the selected input. No value while `release_when` does not hold.
std::optional<ChannelFrame> Output::control_frame(Instant now) {
    ChannelFrame frame = map_.apply(selector_.frame(), now);
    const bool returns = stage_ == OutputStage::failsafe;
    awaits_release_ = returns && failsafe_.release_when && !failsafe_.release_when->matches(frame);
    if (awaits_release_) {
        return std::nullopt;
    }
    if (returns) {
        counts_.recoveries += held_ ? 1U : 0U;
        glide_from_latest(failsafe_.slew_us_per_second);
    } else if (selector_.changed_over()) {
        ++counts_.changeovers;
        glide_from_latest(changeover_us_per_second_);
    }
    stage_ = OutputStage::control;
    glide_.apply(frame, now);
    held_ = frame;
    return frame;
}

void Output::enter_failsafe() {
    stage_ = OutputStage::failsafe;
    ++counts_.failsafe_entries;
    glide_from_latest(failsafe_.slew_us_per_second);
}

/// Frame of an output that no input feeds. It sends named values, each of which is fresh or marked
/// stale. Nothing is held, and there are no presets.
std::optional<ChannelFrame> Output::frame_without_inputs(bool yielding) {
    stage_ = yielding ? OutputStage::failsafe : OutputStage::control;
    if (yielding) {
        return std::nullopt;
    }
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    frame.cause = LinkCause::good;
    return frame;
}

std::optional<ChannelFrame> Output::make_frame(Instant now, std::span<const Input> inputs) {
    const Instant end_of_period = later(now, schedule_.period());
    const bool yielding = must_yield(now);
    if (selector_.inputs().empty()) {
        return frame_without_inputs(yielding);
    }
    const bool bridging = stage_ != OutputStage::failsafe;
    if (!yielding && selector_.select(now, end_of_period, inputs, bridging)) {
        const auto frame = control_frame(now);
        return frame ? frame : failsafe_frame(now);
    }
    awaits_release_ = false;
    if (bridging) {
        if (stage_ == OutputStage::control) {
            // An input that lost control for another reason may still be alive.
            const Instant lost_at = inputs[*selector_.current()].link().lost_at();
            holding_since_ = lost_at <= end_of_period ? lost_at : now;
        }
        stage_ = OutputStage::holding;
        if (!yielding && end_of_period < later(holding_since_, failsafe_.hold)) {
            ChannelFrame frame = *held_;
            frame.frame_lost = true;
            return frame;
        }
        enter_failsafe();
    }
    return failsafe_frame(now);
}

/// Replaces absent channels by their presets if the format cannot mark a channel as absent.
[[gnu::noinline]] void Output::fill_absent(ChannelFrame& frame, Instant now) {
    const std::uint32_t needed = encoder_.encoder().needed_channels(frame);
    std::uint32_t missing = needed & frame.absent();
    if (missing == 0) {
        return;
    }
    by_preset_ = missing & mapped_channels_;
    for (; missing != 0; missing &= missing - 1) {
        const auto channel = static_cast<std::size_t>(std::countr_zero(missing));
        frame.set(channel, failsafe_.presets[channel]);
    }
    map_.restart_from(frame, now);
}

void Output::run(Instant now, std::span<const Input> inputs) {
    std::optional<ChannelFrame> frame = make_frame(now, inputs);
    if (frame && !selector_.inputs().empty()) {
        const std::size_t judged_input = selector_.current().value_or(selector_.inputs().front());
        frame->cause = inputs[judged_input].state().cause;
    }
    by_preset_ = 0;
    if (frame && !frame->has_first(kChannelCount) && !selector_.inputs().empty()) {
        fill_absent(*frame, now);
    }
    if (frame) {
        latest_ = *frame;
        latest_due_ = schedule_.due();
        latest_at_ = now;
        transmission_ = encoder_.encode(*frame, now);
    }
    made_frame_ = frame.has_value();
    if (!made_frame_ && obstacle_ != SendObstacle::device) {
        // A silent output cannot find out whether the obstacle has gone.
        obstacle_ = SendObstacle::none;
    }
    schedule_.done(now, made_frame_);
}

}  // namespace tribus
