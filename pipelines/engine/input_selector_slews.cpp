#include "pipelines/engine/input_selector.h"

namespace tribus {

void InputSelector::take_slews(std::span<const Input> inputs) {
    auto limits = std::make_unique<SlewLimits>();
    for (const std::size_t index : settings_.inputs) {
        limits->add(inputs[index].map());
    }
    if (limits->any()) {
        slew_limits_ = std::move(limits);
    }
}

[[gnu::noinline]] void InputSelector::keep_slews(bool anew, Duration passed) {
    if (anew || changed_over_) {
        slew_limits_->start(frame_);
    } else if (voted_) {
        slew_limits_->apply_to_all(frame_, passed);
    } else {
        slew_limits_->apply(frame_, *place_, passed);
    }
}

}  // namespace tribus
