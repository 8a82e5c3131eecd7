#include <optional>
#include <span>

#include "pipelines/engine/output.h"

namespace tribus {

/// What the sticks say, what the inputs make of it, and what would be sent have to fulfil
/// `release_when`: a slew that starts at a low value hides a high throttle. The slew of the output
/// starts at its preset again in each frame, so one that does not fulfil the rule would keep what
/// would be sent from ever fulfilling it. Then only the others count.
bool Output::released(const ChannelFrame& frame, std::span<const Input> inputs) {
    const ValueRule& rule = *failsafe_.release_when;
    std::optional<ChannelFrame> obstacle;
    bool any = false;
    const auto judge = [&](const ChannelFrame& said) {
        any = any || said.has(rule.channel);
        if (!obstacle && said.has(rule.channel) && !rule.matches(said)) {
            obstacle = said;
        }
    };
    selector_.for_each_aim(inputs, [&](const ChannelFrame& aim) { judge(map_.aim(aim)); });
    judge(map_.aim(selector_.frame()));
    const bool starts_beyond = failsafe_.action == FailsafeAction::preset &&
                               !rule.matches(failsafe_.presets[rule.channel]);
    if (!starts_beyond) {
        judge(frame);
    }
    ongoing_.release_pulse = obstacle.value_or(frame).channel(rule.channel);
    return any && !obstacle;
}

}  // namespace tribus
