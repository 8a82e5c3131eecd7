#include "app/replay/simulate_log.h"

#include <cstddef>
#include <cstdio>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "app/cli/cause_text.h"

namespace tribus {
namespace {

void print_change(Instant now, std::string_view kind, std::string_view name,
                  std::string_view text) {
    const double seconds = std::chrono::duration<double>(now.time_since_epoch()).count();
    fmt::print(stderr, "{:10.3f} s  {} {}: {}\n", seconds, kind, name, text);
}

}  // namespace

SimulateLog::SimulateLog(const Engine& engine)
    : engine_(engine),
      causes_(engine.inputs().size(), LinkCause::never_seen),
      two_senders_printed_(engine.inputs().size()),
      states_(engine.outputs().size()),
      outputs_(engine.outputs().size(), output_text({}, {})),
      presets_printed_(engine.outputs().size()) {
    for (const Input& input : engine.inputs()) {
        input_names_.push_back(input.name());
    }
}

void SimulateLog::look(Instant now) {
    for (std::size_t i = 0; i < causes_.size(); ++i) {
        const Input& input = engine_.inputs()[i];
        if (input.state().cause != causes_[i]) {
            causes_[i] = input.state().cause;
            print_change(now, "input", input_names_[i], cause_text(input.state()));
        }
        if (input.decoder().two_senders() && !two_senders_printed_[i]) {
            two_senders_printed_[i] = true;
            print_change(now, "input", input_names_[i], kTwoSendersText);
        }
    }
    // The state of an output changes only when it runs.
    for (const std::size_t i : engine_.ran()) {
        const Output& output = engine_.outputs()[i];
        const OutputState state = output.state(now);
        if (state == states_[i]) {
            continue;
        }
        states_[i] = state;
        std::string text = output_text(state, input_names_);
        if (text != outputs_[i]) {
            outputs_[i] = std::move(text);
            print_change(now, "output", output.name(), outputs_[i]);
        }
        if ((state.by_preset & ~presets_printed_[i]) != 0) {
            presets_printed_[i] |= state.by_preset;
            print_change(now, "output", output.name(), by_preset_text(state.by_preset));
        }
    }
}

}  // namespace tribus
