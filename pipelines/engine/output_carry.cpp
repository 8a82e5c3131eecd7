#include <utility>

#include "pipelines/engine/output.h"

namespace tribus {

void Output::continue_from(Output& before, const OutputCarry& carry,
                           std::span<const InputCarry> carried_inputs, Instant now) {
    if (carry.same_schedule) {
        schedule_ = before.schedule_;
    } else {
        schedule_.continue_from(before.schedule_, now);
    }
    encoder_.encoder().continue_from(before.encoder_.encoder());
    selector_.continue_from(before.selector_, carried_inputs);
    glide_ = before.glide_;
    stage_ = before.stage_;
    obstacle_ = before.obstacle_;
    busy_run_ = before.busy_run_;
    forced_ = before.forced_;
    awaits_release_ = before.awaits_release_;
    foreign_seen_ = before.foreign_seen_;
    foreign_run_ = before.foreign_run_;
    yield_until_ = before.yield_until_;
    held_ = before.held_;
    holding_since_ = before.holding_since_;
    made_frame_ = before.made_frame_;
    latest_ = before.latest_;
    latest_due_ = before.latest_due_;
    latest_at_ = before.latest_at_;
    counts_ = before.counts_;
    map_.set_lines(before.map_.lines());
    if (carry.same_channels) {
        std::swap(map_, before.map_);
    } else {
        take_up_channels();
    }
    if (stage_ == OutputStage::failsafe && !carry.same_failsafe) {
        glide_from_latest(failsafe_.slew_us_per_second);
    }
    if (selector_.inputs().empty()) {
        return;
    }
    if (stage_ == OutputStage::control && !selector_.current()) {
        stage_ = OutputStage::holding;
        holding_since_ = now;
    }
    // An output that had no inputs before has no values to hold.
    stage_ = held_ ? stage_ : OutputStage::failsafe;
}

/// For a changed map: slews start from the latest frame, and held values become those that the new
/// map makes of the same input.
void Output::take_up_channels() {
    if (made_frame_) {
        map_.restart_from(latest_, latest_at_);
    }
    if (held_) {
        const ChannelFrame said = *held_;
        held_ = map_.apply(selector_.frame(), latest_at_);
        held_->frame_lost = said.frame_lost;
        held_->failsafe = said.failsafe;
        held_->cause = said.cause;
    }
}

}  // namespace tribus
