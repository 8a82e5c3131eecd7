#include "pipelines/output.h"

#include <algorithm>
#include <utility>

namespace tribus {
namespace {

/// Longer than the period of any sender that a reader would mistake for this one.
constexpr Duration kForeignSenderMemory = std::chrono::seconds(1);
/// Fewer are no sender: what a program that has just ended left in the controller, or somebody's
/// experiment. Readers of a protected format see through them.
constexpr int kForeignSenderFrames = 3;

}  // namespace

Output::Output(OutputSettings settings)
    : name_(std::move(settings.name)),
      encoder_(std::move(settings.encoder)),
      can_encoder_(std::move(settings.can_encoder)),
      yield_to_foreign_sender_(settings.yield_to_foreign_sender),
      schedule_(settings.schedule),
      inputs_(std::move(settings.inputs)),
      map_(settings.channels),
      failsafe_(settings.failsafe),
      can_frames_(can_encoder_ ? kMostSnapshotFrames : 0) {}

void Output::frame_arrived(std::size_t index, const ArrivalClock& arrivals) {
    const bool standby = stage_ == OutputStage::control && index != current_;
    if (!standby) {
        schedule_.frame_arrived(arrivals);
    }
}

void Output::end(Instant now) {
    ending_ = true;
    stage_ = OutputStage::failsafe;
    schedule_.start(now);
}

Transmission Output::take() {
    return {.bytes = std::span(wire_).first(std::exchange(wire_length_, 0)),
            .can_frames = std::span(can_frames_).first(std::exchange(can_frame_count_, 0))};
}

std::span<const CanIdMatch> Output::sent_ids() const {
    return can_encoder_ ? can_encoder_->sent() : std::span<const CanIdMatch>{};
}

void Output::foreign_frame_seen(Instant now) {
    ++counts_.foreign_frames;
    const bool goes_on = foreign_run_ > 0 && now < later(foreign_seen_, kForeignSenderMemory);
    foreign_run_ = goes_on ? std::min(foreign_run_ + 1, kForeignSenderFrames) : 1;
    foreign_seen_ = now;
    if (foreign_run_ == kForeignSenderFrames) {
        // Afterwards `recover` is due, as after any failsafe; the input was never lost, so `select`
        // would not ask for it.
        yield_until_ = later(later(now, kForeignSenderMemory), failsafe_.recover);
    }
}

bool Output::must_yield(Instant now) const {
    return ending_ || (yield_to_foreign_sender_ && now < yield_until_);
}

std::optional<std::size_t> Output::controlling_input() const {
    return stage_ == OutputStage::control ? current_ : std::nullopt;
}

/// The first healthy input in the order of preference. One that was lost must have shown an
/// unbroken run of good frames before it gets control back, except from a loss that its own
/// `hold` has bridged.
std::optional<std::size_t> Output::select(Instant now, Instant at,
                                          std::span<const Input> inputs) const {
    for (const std::size_t index : inputs_) {
        const Input& input = inputs[index];
        const bool trusted = (index == current_ && stage_ != OutputStage::failsafe) ||
                             input.first_run() || now - input.run_start() >= failsafe_.recover;
        if (input.alive(at) && trusted) {
            return index;
        }
    }
    return std::nullopt;
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
            map_.restart_from(frame, now);
            break;
    }
    frame.frame_lost = true;
    frame.failsafe = true;
    return frame;
}

std::optional<ChannelFrame> Output::make_frame(Instant now, std::span<const Input> inputs) {
    const Instant end_of_period = later(now, schedule_.period());
    const bool yielding = must_yield(now);
    const auto selected = yielding ? std::nullopt : select(now, end_of_period, inputs);
    if (selected) {
        if (stage_ == OutputStage::failsafe && current_) {
            ++counts_.recoveries;
        }
        current_ = selected;
        stage_ = OutputStage::control;
        held_ = map_.apply(inputs[*selected].control(), now);
        return held_;
    }
    if (stage_ != OutputStage::failsafe) {
        stage_ = OutputStage::holding;
        if (!yielding && end_of_period < later(inputs[*current_].lost_at(), failsafe_.hold)) {
            ChannelFrame frame = *held_;
            frame.frame_lost = true;
            return frame;
        }
        stage_ = OutputStage::failsafe;
        ++counts_.failsafe_entries;
    }
    return failsafe_frame(now);
}

void Output::run(Instant now, std::span<const Input> inputs) {
    const std::optional<ChannelFrame> frame = make_frame(now, inputs);
    if (frame) {
        latest_ = *frame;
        latest_due_ = schedule_.due();
        if (can_encoder_) {
            can_frame_count_ = can_encoder_->encode(
                *frame, now, std::span<CanFrame, kMostSnapshotFrames>(can_frames_));
        } else {
            wire_length_ = encoder_->encode(*frame, wire_);
        }
    }
    schedule_.done(now, frame.has_value());
}

}  // namespace tribus
