#include <utility>

#include "pipelines/engine/input_selector.h"

namespace tribus {

void InputSelector::take_slews(std::span<const Input> inputs) {
    auto limits = std::make_unique<SlewLimits>();
    for (const std::size_t index : settings_.inputs) {
        limits->add(inputs[index].map());
    }
    if (limits->any()) {
        slew_limits_ = std::move(limits);
        only_one_ = false;
    }
}

/// Between failsafes, each frame of the output begins with a selection. `anew`: after failsafe, the
/// values before do not count.
void InputSelector::keep_slews(bool anew, Instant now) {
    const Duration passed = now - std::exchange(selected_at_, now);
    if (anew || changed_over_) {
        slew_limits_->start(frame_);
    } else if (voted_) {
        slew_limits_->apply_to_all(frame_, passed);
    } else {
        slew_limits_->apply(frame_, *place_, passed);
    }
}

}  // namespace tribus
