#include "pipelines/engine/output_wait.h"

#include <algorithm>

#include "pipelines/engine/output.h"

namespace tribus {

OutputWait Output::wait(Instant now, std::span<const Input> inputs) const {
    if (stage() == OutputStage::control || stage() == OutputStage::cannot_send) {
        return {};
    }
    if (ending_) {
        return {.awaited = Awaited::end};
    }
    if (ongoing_.forced) {
        return {.awaited = Awaited::line};
    }
    if (now < ongoing_.yield_until) {
        const bool still_heard = yield_to_foreign_sender_ &&
                                 now < later(ongoing_.foreign_seen, kForeignSenderMemory) &&
                                 ongoing_.foreign_run == kForeignSenderFrames;
        // A reload may have shortened `recover` meanwhile.
        const Duration left = std::min(ongoing_.yield_until - now, failsafe_.recover);
        return still_heard ? OutputWait{.awaited = Awaited::other_node}
                           : OutputWait{.awaited = Awaited::after_force,
                                        .so_far = failsafe_.recover - left,
                                        .needed = failsafe_.recover};
    }
    if (ongoing_.awaits_release) {
        return {.awaited = Awaited::release,
                .release_when = *failsafe_.release_when,
                .pulse = ongoing_.release_pulse};
    }
    return selector_.wait(now, later(now, period()), inputs,
                          ongoing_.stage != OutputStage::failsafe);
}

bool Output::could_use(std::size_t input, Instant now, std::span<const Input> inputs) const {
    return selector_.could_use(input, now, later(now, period()), inputs,
                               ongoing_.stage != OutputStage::failsafe);
}

}  // namespace tribus
