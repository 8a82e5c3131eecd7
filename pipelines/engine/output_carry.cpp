#include <algorithm>
#include <cmath>
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
    selector_.continue_from(before.selector_, carried_inputs, before.ongoing_.latest_at);
    ongoing_ = before.ongoing_;
    ongoing_.answers = encoder_.encoder().answers();
    map_.set_lines(before.map_.lines());
    if (carry.same_channels) {
        std::swap(map_, before.map_);
    } else {
        take_up_channels();
    }
    retime_glide(before);
    if (ongoing_.stage == OutputStage::failsafe && !carry.same_failsafe && glides_into_failsafe()) {
        glide_from_latest(failsafe_.slew_us_per_second);
    }
    if (selector_.inputs().empty()) {
        return;
    }
    if (ongoing_.stage == OutputStage::control && !selector_.current()) {
        ongoing_.stage = OutputStage::holding;
        ongoing_.holding_since = now;
    }
    // An output that had no inputs before has no values to hold.
    ongoing_.stage = ongoing_.held ? ongoing_.stage : OutputStage::failsafe;
}

/// New rates count from the next frame on, also for channels that are on their way: at the slower
/// of those that there are.
void Output::retime_glide(const Output& before) {
    const auto& slew = failsafe_.slew_us_per_second;
    const auto& changeover = changeover_us_per_second_;
    if (slew == before.failsafe_.slew_us_per_second &&
        changeover == before.changeover_us_per_second_) {
        return;
    }
    if (!slew && !changeover) {
        ongoing_.glide.stop();
        return;
    }
    ongoing_.glide.set_rate(std::min(slew.value_or(HUGE_VAL), changeover.value_or(HUGE_VAL)));
}

/// For a changed map: slews start from the latest frame, whenever that was, and held values become
/// those that the new map makes of the same input.
void Output::take_up_channels() {
    map_.restart_from(ongoing_.latest, ongoing_.latest_at);
    if (ongoing_.held) {
        const ChannelFrame said = *ongoing_.held;
        ongoing_.held = map_.apply(selector_.frame(), ongoing_.latest_at);
        ongoing_.glide.show(*ongoing_.held);
        ongoing_.held->frame_lost = said.frame_lost;
        ongoing_.held->failsafe = said.failsafe;
        ongoing_.held->cause = said.cause;
    }
}

}  // namespace tribus
