#include "pipelines/engine/output.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace tribus {
namespace {

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
      failsafe_(settings.failsafe),
      least_asked_period_(settings.least_asked_period),
      may_withhold_(encoder_.encoder().may_withhold()) {}

void Output::frame_arrived(std::size_t index, const ArrivalClock& arrivals) {
    const bool standby = ongoing_.stage == OutputStage::control && index != selector_.current();
    if (!standby) {
        schedule_.frame_arrived(arrivals);
    }
}

void Output::end(Instant now) {
    ending_ = true;
    ongoing_.stage = OutputStage::failsafe;
    ongoing_.glide.stop();
    schedule_.start(now);
}

void Output::foreign_frame_seen(Instant now) {
    ++ongoing_.counts.foreign_frames;
    const bool goes_on =
        ongoing_.foreign_run > 0 && now < later(ongoing_.foreign_seen, kForeignSenderMemory);
    ongoing_.foreign_run = goes_on ? std::min(ongoing_.foreign_run + 1, kForeignSenderFrames) : 1;
    ongoing_.foreign_seen = now;
    if (yield_to_foreign_sender_ && ongoing_.foreign_run == kForeignSenderFrames) {
        // `recover` applies afterwards, as after any failsafe. `select` would not enforce it,
        // because the input was never lost.
        ongoing_.yield_until = later(later(now, kForeignSenderMemory), failsafe_.recover);
    }
}

void Output::force_failsafe(bool on, Instant now) {
    if (ongoing_.forced && !on) {
        ongoing_.yield_until = std::max(ongoing_.yield_until, later(now, failsafe_.recover));
    }
    ongoing_.forced = on;
}

bool Output::must_yield(Instant now) const {
    return ending_ || ongoing_.forced || now < ongoing_.yield_until;
}

OutputState Output::state(Instant now) const {
    OutputState state{
        .stage = stage(),
        .obstacle = ongoing_.obstacle,
        .awaits_release = ongoing_.awaits_release,
        .forced = must_yield(now),
        .input = selector_.follows_one() ? controlling_input().value_or(kNoInput) : kNoInput,
        .outvoted = 0,
        .marks_frame_lost = encoder_.encoder().marks_frame_lost(),
        .by_preset = by_preset_,
        .hearing = encoder_.encoder().hearing(now)};
    for (std::size_t place = 0; place < inputs().size(); ++place) {
        state.outvoted |= selector_.outvoted(place) ? 1U << place : 0U;
    }
    return state;
}

Instant Output::look_at_stage(Instant now) {
    if (stage() != ongoing_.stage_before) {
        ongoing_.stage_before = stage();
        ongoing_.stage_since = stage() == OutputStage::holding ? ongoing_.holding_since : now;
    }
    return std::min(ongoing_.stage_since, now);
}

std::optional<std::size_t> Output::controlling_input() const {
    return stage() == OutputStage::control ? selector_.current() : std::nullopt;
}

[[gnu::cold]] void Output::hear(std::span<const std::uint8_t> bytes, Instant now) {
    const auto asked = encoder_.hear(bytes, now);
    ongoing_.answers = encoder_.encoder().answers();
    if (asked && asked->at_once) {
        schedule_.due_at_once(now);
    } else if (asked) {
        const Duration period =
            std::clamp(asked->period, least_asked_period_, OutputSettings::kMostAskedPeriod);
        // With another period than was asked for there is no phase to hold.
        schedule_.retime(period, period == asked->period ? asked->later : Duration::zero());
    }
}

void Output::dropped_busy() {
    ++ongoing_.counts.busy_drops;
    ongoing_.busy_run = std::min(ongoing_.busy_run + 1, kBusyFrames);
    if (ongoing_.busy_run == kBusyFrames) {
        ongoing_.obstacle = SendObstacle::busy;
    }
}

void Output::dropped_lost() {
    ++ongoing_.counts.lost_drops;
    ongoing_.obstacle = SendObstacle::device;
}

void Output::dropped_unavailable() {
    ++ongoing_.counts.unavailable_drops;
    ongoing_.obstacle = SendObstacle::bus;
}

void Output::set_device_present(bool present) {
    if (!present) {
        ongoing_.obstacle = SendObstacle::device;
    } else if (ongoing_.obstacle == SendObstacle::device) {
        ongoing_.obstacle = SendObstacle::none;
    }
}

bool Output::make_failsafe_frame(ChannelFrame& frame, Instant now) {
    frame = {};
    if (ending_ && farewells() > 0) {
        // The encoder's last frames take the place of silence.
        return false;
    }
    switch (failsafe_.action) {
        case FailsafeAction::silence:
            return false;
        case FailsafeAction::hold:
            if (!ongoing_.held) {
                return false;
            }
            frame = *ongoing_.held;
            break;
        case FailsafeAction::preset:
            for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
                frame.set(channel, failsafe_.presets[channel]);
            }
            ongoing_.glide.apply(frame, now);
            break;
    }
    frame.frame_lost = true;
    frame.failsafe = true;
    return true;
}

/// Starts at the time of the latest frame, so that already the first frame of the glide moves.
void Output::glide_from_latest(std::optional<double> us_per_second) {
    if (us_per_second && ongoing_.made_frame) {
        ongoing_.glide.start(ongoing_.latest, *us_per_second, ongoing_.latest_at);
    } else {
        ongoing_.glide.stop();
    }
}

/// A limit that still leads back from the presets does not end before it has.
void Output::glide_to_another_input() {
    ++ongoing_.counts.changeovers;
    ongoing_.told_stand = ~stand();
    if (!changeover_us_per_second_) {
        return;
    }
    if (ongoing_.made_frame) {
        ongoing_.glide.start_anew(ongoing_.latest, *changeover_us_per_second_, ongoing_.latest_at);
    } else {
        ongoing_.glide.stop();
    }
}

/// Held values do not move, so the time until the latest frame does not count. After failsafe,
/// channels go on from the latest frame.
void Output::rest_slews(bool after_failsafe) {
    map_.rest(ongoing_.latest_at);
    ongoing_.glide.rest(ongoing_.latest_at);
    if (after_failsafe) {
        // The channel of `release_when` moves while others are held, or it would wait for ever.
        const bool moves = failsafe_.action == FailsafeAction::hold && failsafe_.release_when;
        const std::uint32_t moving = moves ? 1U << failsafe_.release_when->channel : 0;
        map_.restart_from(ongoing_.latest, ongoing_.latest_at, ~moving);
    }
}

/// The first frame of the selected input after failsafe or held values. False while `release_when`
/// does not hold.
bool Output::make_first_control_frame(ChannelFrame& frame, Instant now,
                                      std::span<const Input> inputs) {
    const bool returns = ongoing_.stage == OutputStage::failsafe;
    rest_slews(returns);
    map_.apply(selector_.frame(), frame, now);
    ongoing_.awaits_release = returns && failsafe_.release_when && !released(frame, inputs);
    if (ongoing_.awaits_release) {
        return false;
    }
    if (returns) {
        ongoing_.counts.recoveries += ongoing_.held ? 1U : 0U;
        glide_from_latest(failsafe_.slew_us_per_second);
    } else if (selector_.changed_over()) {
        glide_to_another_input();
    }
    return true;
}

/// The frame of the selected input. False while `release_when` does not hold.
bool Output::make_control_frame(ChannelFrame& frame, Instant now, std::span<const Input> inputs) {
    if (ongoing_.stage != OutputStage::control) {
        if (!make_first_control_frame(frame, now, inputs)) {
            return false;
        }
    } else {
        map_.apply(selector_.frame(), frame, now);
        if (selector_.changed_over()) {
            glide_to_another_input();
        }
    }
    ongoing_.stage = OutputStage::control;
    valid_until_ = selector_.alive_until();
    ongoing_.glide.apply(frame, now);
    ongoing_.held = frame;
    ongoing_.holding_since = valid_until_;
    return true;
}

void Output::enter_failsafe() {
    ongoing_.stage = OutputStage::failsafe;
    ++ongoing_.counts.failsafe_entries;
    if (glides_into_failsafe()) {
        glide_from_latest(failsafe_.slew_us_per_second);
    }
}

/// Frame of an output that no input feeds. It sends named values, each of which is fresh or marked
/// stale. Nothing is held, and there are no presets.
bool Output::make_frame_without_inputs(ChannelFrame& frame, bool yielding) {
    ongoing_.stage = yielding ? OutputStage::failsafe : OutputStage::control;
    frame.frame_lost = false;
    frame.failsafe = false;
    frame.cause = LinkCause::good;
    return !yielding;
}

/// Returns false if the output stays silent.
bool Output::make_frame(ChannelFrame& frame, Instant now, std::span<const Input> inputs) {
    const Instant end_of_period = later(now, schedule_.period());
    const bool yielding = must_yield(now);
    if (selector_.inputs().empty()) {
        return make_frame_without_inputs(frame, yielding);
    }
    const bool bridging = ongoing_.stage != OutputStage::failsafe;
    if (!yielding && selector_.select(now, end_of_period, inputs, bridging)) {
        return make_control_frame(frame, now, inputs) || make_failsafe_frame(frame, now);
    }
    ongoing_.awaits_release = false;
    if (bridging) {
        const bool was_in_control = ongoing_.stage == OutputStage::control;
        if (was_in_control) {
            // Frames that waited through a stall may have moved the input's loss, and do not make
            // the held values younger. An input that lost control for another reason may still be
            // alive.
            const Instant lost_at =
                std::min(inputs[*selector_.current()].link().lost_at(), ongoing_.holding_since);
            ongoing_.holding_since = lost_at <= end_of_period ? lost_at : now;
        }
        ongoing_.stage = OutputStage::holding;
        valid_until_ = later(ongoing_.holding_since, failsafe_.hold);
        if (!yielding && end_of_period < valid_until_) {
            ongoing_.counts.hold_entries += was_in_control ? 1U : 0U;
            frame = *ongoing_.held;
            frame.frame_lost = true;
            return true;
        }
        enter_failsafe();
    }
    return make_failsafe_frame(frame, now);
}

/// Replaces absent channels by their presets if the format cannot mark a channel as absent.
void Output::fill_absent(ChannelFrame& frame, Instant now) {
    const std::uint32_t needed = encoder_.encoder().needed_channels(frame);
    const std::uint32_t missing = needed & frame.absent();
    if (missing == 0) {
        return;
    }
    by_preset_ = missing & mapped_channels_;
    for (std::uint32_t left = missing; left != 0; left &= left - 1) {
        const auto channel = static_cast<std::size_t>(std::countr_zero(left));
        frame.set(channel, failsafe_.presets[channel]);
    }
    if (by_preset_ != 0) {
        map_.restart_from(frame, now, by_preset_);
    }
}

/// No channels leave that the encoder withholds, whatever the link hands over.
void Output::look_for_withheld() {
    const Withheld withheld = encoder_.encoder().withheld();
    if (!ongoing_.made_frame || withheld == Withheld::nothing) {
        return;
    }
    ongoing_.made_frame = false;
    if (ongoing_.obstacle != SendObstacle::device) {
        ongoing_.obstacle =
            withheld == Withheld::no_receiver ? SendObstacle::receiver : SendObstacle::epoch;
    }
}

void Output::run(Instant now, std::span<const Input> inputs) {
    ChannelFrame frame;
    valid_until_ = kNever;
    const bool made = make_frame(frame, now, inputs);
    by_preset_ = 0;
    if (made && !selector_.inputs().empty()) {
        const std::size_t judged_input = selector_.current().value_or(selector_.inputs().front());
        frame.cause = inputs[judged_input].state().cause;
        if (ongoing_.stage != OutputStage::control && frame.cause == LinkCause::good) {
            frame.cause = LinkCause::unproved;
        }
        if (!frame.has_first(kChannelCount)) {
            fill_absent(frame, now);
        }
    }
    if (made) {
        ongoing_.latest = frame;
        ongoing_.latest_due = schedule_.due();
        ongoing_.latest_at = now;
        transmission_ = encoder_.encode(ongoing_.latest, now);
    } else {
        transmission_ = encoder_.encode_silence(now);
    }
    ongoing_.made_frame = made;
    if (!ongoing_.made_frame && ongoing_.obstacle != SendObstacle::device) {
        // A silent output cannot find out whether the obstacle has gone.
        ongoing_.obstacle = SendObstacle::none;
    }
    if (may_withhold_) {
        look_for_withheld();
    }
    schedule_.done(now, ongoing_.made_frame, valid_until_);
    if (stand() != ongoing_.told_stand) {
        tell_change(now);
    }
}

[[gnu::cold]] void Output::tell_change(Instant now) {
    ongoing_.told_stand = stand();
    if (watch_ != nullptr) {
        watch_->output_changed(index_, now);
    }
}

}  // namespace tribus
