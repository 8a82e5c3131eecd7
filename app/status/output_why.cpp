#include "app/status/output_why.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/state_text/cause_text.h"
#include "app/state_text/wait_text.h"
#include "app/status/status.h"

namespace tribus {
namespace {

/// Says what the output sends while it is not in control.
std::string sends_text(const OutputStatus& status, const FailsafeSettings* failsafe, Instant now) {
    if (status.state.stage == OutputStage::holding && failsafe != nullptr) {
        const Duration left = failsafe->hold - (now - status.stage_since);
        return left > Duration::zero() ? "failsafe in " + duration_text(left) : "";
    }
    if (status.state.stage == OutputStage::failsafe) {
        const bool holds = failsafe != nullptr && failsafe->action == FailsafeAction::hold;
        return !status.sends ? "it sends nothing"
               : holds       ? "it sends the last values"
                             : "it sends its presets";
    }
    return "";
}

/// "radio lost (the receiver says failsafe) for 4.2 s"
std::string lack_of(const InputStatus& input, Instant now) {
    const std::string cause = cause_text(input.state, input.implausible, input.fault.view());
    return input.state.cause == LinkCause::never_seen
               ? cause
               : fmt::format("{} for {}", cause, duration_text(now - input.state.since));
}

}  // namespace

const FailsafeSettings* failsafe_of(const StatusPart& part) {
    for (const PipelineConfig& pipeline : part.report.configuration->pipelines) {
        const auto found = std::ranges::find(pipeline.outputs, part.index);
        if (found != pipeline.outputs.end()) {
            return &pipeline.failsafe[static_cast<std::size_t>(found - pipeline.outputs.begin())];
        }
    }
    return nullptr;
}

std::string output_why(const StatusPart& part) {
    const StatusReport& report = part.report;
    const OutputReport& output = report.outputs[part.index];
    const OutputState& state = output.status.state;
    const OutputWait& wait = output.status.wait;
    const auto names = input_names(*report.configuration);
    const auto lack = [&](std::size_t input) {
        return fmt::format("{}: {}", names[input],
                           lack_of(report.inputs[input].status, report.now));
    };
    std::vector<std::string> parts{sends_text(output.status, failsafe_of(part), report.now)};
    const auto awaited_input = state.stage == OutputStage::cannot_send ? std::nullopt : wait.input;
    const std::string awaited = awaited_input && wait.awaited == Awaited::link
                                    ? lack(*awaited_input)
                                    : wait_text(state, wait, names);
    parts.push_back(awaited.empty() ? "" : "waits for " + awaited);
    for (std::size_t place = 0; place < output.inputs.size(); ++place) {
        const std::size_t input = output.inputs[place];
        const bool good = report.inputs[input].status.state.cause == LinkCause::good;
        if (awaited_input == input) {
            continue;
        }
        if ((state.outvoted >> place & 1U) != 0) {
            parts.push_back(names[input] + ": outvoted by the others");
        } else if (!good) {
            parts.push_back(lack(input));
        }
    }
    std::erase(parts, "");
    return fmt::format("{}", fmt::join(parts, "; "));
}

}  // namespace tribus
