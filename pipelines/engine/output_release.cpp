#include <optional>
#include <span>

#include "pipelines/engine/output.h"

namespace tribus {

/// Three frames must fulfil `release_when`: the sticks, the inputs' own maps of them, and the frame
/// that would be sent. A slew that starts at a low value would hide a high throttle from the last
/// one. A preset that does not fulfil the rule would keep the last one from ever fulfilling it,
/// because the output's slew starts there again in each frame; then only the first two count.
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
