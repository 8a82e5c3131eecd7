#include "pipelines/engine/line_roles.h"

#include <algorithm>

namespace tribus {
namespace {

enum class Shown { off, blinking, on };

bool unmarked(const Output& output) {
    return !output.latest().frame_lost && !output.latest().failsafe;
}

Shown link_lamp(const Output& output) {
    switch (output.stage()) {
        case OutputStage::failsafe:
        case OutputStage::cannot_send:
            return Shown::off;
        case OutputStage::control:
            return unmarked(output) ? Shown::on : Shown::blinking;
        case OutputStage::holding:
            break;
    }
    return Shown::blinking;
}

/// The lowest state of all outputs: off, else blinking, else on.
Shown link_lamp(const LineTask& task, std::span<const Output> outputs) {
    Shown darkest = Shown::on;
    for (const std::size_t output : task.outputs) {
        darkest = std::min(darkest, link_lamp(outputs[output]));
    }
    return darkest;
}

bool any_in_failsafe(const LineTask& task, std::span<const Output> outputs) {
    return std::ranges::any_of(task.outputs, [&](std::size_t output) {
        const OutputStage stage = outputs[output].stage();
        return stage == OutputStage::failsafe || stage == OutputStage::cannot_send;
    });
}

bool switched_on(const LineTask& task, std::span<const Output> outputs) {
    return std::ranges::any_of(task.outputs, [&](std::size_t output) {
        return outputs[output].sends() && outputs[output].stage() != OutputStage::cannot_send &&
               task.rule.matches(outputs[output].latest());
    });
}

Shown shown_by(const LineTask& task, std::span<const Output> outputs) {
    const auto on_if = [](bool on) { return on ? Shown::on : Shown::off; };
    switch (task.role) {
        case LineRole::link:
            return link_lamp(task, outputs);
        case LineRole::failsafe:
            return on_if(any_in_failsafe(task, outputs));
        case LineRole::channel_switch:
            return on_if(switched_on(task, outputs));
        case LineRole::inverter:
            return Shown::on;
        case LineRole::fresh:
        case LineRole::force_failsafe:
        case LineRole::select:
        case LineRole::button:
            break;
    }
    return Shown::off;
}

bool names(const std::vector<std::size_t>& outputs, std::size_t output) {
    return std::ranges::find(outputs, output) != outputs.end();
}

}  // namespace

bool LineRoles::forces(std::size_t output, LineLevels levels) const {
    for (std::size_t line = 0; line < tasks_.size(); ++line) {
        if (tasks_[line].role == LineRole::force_failsafe && names(tasks_[line].outputs, output) &&
            levels.of(line).value_or(true)) {
            return true;
        }
    }
    return false;
}

std::optional<std::size_t> LineRoles::picked(std::span<const std::size_t> inputs,
                                             LineLevels levels) const {
    for (std::size_t line = 0; line < tasks_.size(); ++line) {
        const auto place = std::ranges::find(inputs, tasks_[line].input);
        if (tasks_[line].role == LineRole::select && place != inputs.end() &&
            levels.of(line).value_or(false)) {
            return static_cast<std::size_t>(place - inputs.begin());
        }
    }
    return std::nullopt;
}

LineStates LineRoles::shown(std::span<const Output> outputs) const {
    LineStates states;
    for (std::size_t line = 0; line < tasks_.size(); ++line) {
        const Shown shown = shown_by(tasks_[line], outputs);
        states.on |= shown == Shown::on ? line_bit(line) : 0U;
        states.blinking |= shown == Shown::blinking ? line_bit(line) : 0U;
    }
    return states;
}

bool is_fresh(const Output& output, Instant handed_over) {
    return output.stage() == OutputStage::control && unmarked(output) &&
           handed_over <= later(output.latest_due(), output.period() / 2);
}

}  // namespace tribus
