#include "app/simulate_log.h"

#include <cstddef>
#include <cstdio>
#include <string_view>

#include <fmt/format.h>

#include "app/cause_text.h"

namespace tribus {
namespace {

void say(Instant now, std::string_view kind, std::string_view name, std::string_view text) {
    const double seconds = std::chrono::duration<double>(now.time_since_epoch()).count();
    fmt::print(stderr, "{:10.3f} s  {} {}: {}\n", seconds, kind, name, text);
}

}  // namespace

SimulateLog::SimulateLog(const Engine& engine)
    : engine_(engine),
      causes_(engine.inputs().size(), LinkCause::never_seen),
      outputs_(engine.outputs().size()) {
    for (const Input& input : engine.inputs()) {
        input_names_.push_back(input.name());
    }
}

void SimulateLog::look(Instant now) {
    for (std::size_t i = 0; i < causes_.size(); ++i) {
        const LinkState& state = engine_.inputs()[i].state();
        if (state.cause != causes_[i]) {
            causes_[i] = state.cause;
            say(now, "input", input_names_[i], cause_text(state));
        }
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        const Output& output = engine_.outputs()[i];
        const OutputState state = output.state(now);
        if (state != outputs_[i]) {
            outputs_[i] = state;
            say(now, "output", output.name(), output_text(state, input_names_));
        }
    }
}

}  // namespace tribus
