#include "app/replay/simulate_log.h"

#include <cstddef>
#include <cstdio>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "app/journal/print_error.h"
#include "app/state_text/cause_text.h"

namespace tribus {
namespace {

void print_change(Instant now, std::string_view kind, std::string_view name,
                  std::string_view text) {
    const double seconds = std::chrono::duration<double>(now.time_since_epoch()).count();
    print_error("{:10.3f} s  {} {}: {}\n", seconds, kind, name, text);
}

}  // namespace

SimulateLog::SimulateLog(const Engine& engine)
    : engine_(engine),
      causes_(engine.inputs().size(), LinkCause::never_seen),
      two_senders_printed_(engine.inputs().size()),
      outputs_(engine.outputs().size()),
      presets_printed_(engine.outputs().size()) {
    for (const Input& input : engine.inputs()) {
        input_names_.push_back(input.name());
    }
}

void SimulateLog::look_at_input(std::size_t index, Instant now) {
    const Input& input = engine_.inputs()[index];
    if (input.state().cause != causes_[index]) {
        const LinkState state = engine_.input_state(index, now);
        // The line of the output that waits for it says what it lacks.
        if (state.cause != LinkCause::unproved) {
            causes_[index] = state.cause;
            print_change(now, "input", input_names_[index],
                         cause_text(state, input.link().implausible(), input.fault().view()));
        }
    }
    if (input.decoder().two_senders() && !two_senders_printed_[index]) {
        two_senders_printed_[index] = true;
        print_change(now, "input", input_names_[index], kTwoSendersText);
    }
}

void SimulateLog::look_at_output(std::size_t index, Instant now) {
    const Output& output = engine_.outputs()[index];
    OutputMemory& memory = outputs_[index];
    OutputState state = output.state(now);
    // No module answers here.
    state.hearing = Hearing::not_awaited;
    const OutputWait wait = engine_.wait(index, now);
    // A line about the state says what it waits for, too.
    const bool changed = memory.state && state != *memory.state;
    const std::string& awaited = memory.awaited.look(wait_key(wait, input_names_), changed, now);
    if (state == memory.state && awaited == memory.awaited_printed) {
        return;
    }
    memory.state = state;
    std::string text = output_text(state, input_names_);
    if (text != memory.text || awaited != memory.awaited_printed) {
        const bool same_state = text == memory.text && !awaited.empty();
        memory.text = std::move(text);
        memory.awaited_printed = awaited;
        print_change(now, "output", output.name(),
                     same_state ? "waits for " + wait_text(state, wait, input_names_)
                                : output_sentence(state, wait, input_names_));
    }
    if ((state.by_preset & ~presets_printed_[index]) != 0) {
        presets_printed_[index] |= state.by_preset;
        print_change(now, "output", output.name(), by_preset_text(state.by_preset));
    }
}

void SimulateLog::look(Instant now) {
    for (std::size_t i = 0; i < causes_.size(); ++i) {
        look_at_input(i, now);
    }
    // The state of an output changes only when it runs.
    for (const std::size_t i : engine_.ran()) {
        look_at_output(i, now);
    }
}

}  // namespace tribus
