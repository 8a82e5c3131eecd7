#include "app/simulate_log.h"

#include <cstddef>
#include <cstdio>
#include <string_view>
#include <utility>

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
      two_senders_said_(engine.inputs().size()),
      outputs_(engine.outputs().size(), output_text({}, {})),
      presets_said_(engine.outputs().size()) {
    for (const Input& input : engine.inputs()) {
        input_names_.push_back(input.name());
    }
}

void SimulateLog::look(Instant now) {
    for (std::size_t i = 0; i < causes_.size(); ++i) {
        const Input& input = engine_.inputs()[i];
        if (input.state().cause != causes_[i]) {
            causes_[i] = input.state().cause;
            say(now, "input", input_names_[i], cause_text(input.state()));
        }
        if (input.decoder().two_senders() && !two_senders_said_[i]) {
            two_senders_said_[i] = true;
            say(now, "input", input_names_[i], kTwoSendersText);
        }
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        const Output& output = engine_.outputs()[i];
        const OutputState state = output.state(now);
        std::string text = output_text(state, input_names_);
        if (text != outputs_[i]) {
            outputs_[i] = std::move(text);
            say(now, "output", output.name(), outputs_[i]);
        }
        if ((state.by_preset & ~presets_said_[i]) != 0) {
            presets_said_[i] |= state.by_preset;
            say(now, "output", output.name(), by_preset_text(state.by_preset));
        }
    }
}

}  // namespace tribus
