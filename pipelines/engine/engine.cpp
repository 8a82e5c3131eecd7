#include "pipelines/engine/engine.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace tribus {

Engine::Engine(std::vector<InputSettings> inputs, std::vector<OutputSettings> outputs,
               std::vector<LineTask> lines, std::vector<dronecan::NodeSettings> nodes)
    : line_roles_(std::move(lines)) {
    for (dronecan::NodeSettings& settings : nodes) {
        nodes_.push_back(std::make_unique<dronecan::Node>(std::move(settings)));
    }
    inputs_.reserve(inputs.size());
    for (InputSettings& settings : inputs) {
        inputs_.emplace_back(std::move(settings), static_cast<std::uint8_t>(inputs_.size()));
    }
    outputs_.reserve(outputs.size());
    for (OutputSettings& settings : outputs) {
        node_of_.push_back(settings.node);
        outputs_.emplace_back(std::move(settings));
        outputs_.back().take_slews(inputs_);
        if (node_of_.back()) {
            outputs_.back().send_as(nodes_[*node_of_.back()]->identity());
        }
    }
    fed_by_.resize(inputs_.size());
    for (std::size_t output = 0; output < outputs_.size(); ++output) {
        for (const std::size_t input : outputs_[output].inputs()) {
            fed_by_[input].push_back(output);
        }
    }
    due_.assign(outputs_.size(), kNever);
    ran_.reserve(outputs_.size());
    told_inputs_.resize(inputs_.size());
    told_outputs_.resize(outputs_.size());
    told_nodes_.resize(nodes_.size());
    for (Input& input : inputs_) {
        input.tell_changes_to(*this);
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        outputs_[i].tell_changes_to(*this, i);
        told_outputs_[i] = state_of(i, {});
    }
}

void Engine::start(Instant now) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        nodes_[i]->start(now);
        told_nodes_[i] = nodes_[i]->state();
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        outputs_[i].start(now);
        due_[i] = outputs_[i].due();
    }
}

void Engine::continue_from(Engine& before, const EngineCarry& carry, Instant now) {
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
        if (const CarriedFrom from = carry.inputs[i].from) {
            inputs_[i].continue_from(before.inputs_[*from], carry.inputs[i], now);
            told_inputs_[i] = before.told_inputs_[*from];
        }
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (const CarriedFrom from = carry.nodes[i]) {
            nodes_[i]->continue_from(*before.nodes_[*from]);
            told_nodes_[i] = before.told_nodes_[*from];
        }
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        if (const CarriedFrom from = carry.outputs[i].from) {
            outputs_[i].continue_from(before.outputs_[*from], carry.outputs[i], carry.inputs, now);
            due_[i] = outputs_[i].due();
            // Its inputs may have other numbers now, which is no change of state.
            const PartState& told = before.told_outputs_[*from];
            told_outputs_[i] = {.output = outputs_[i].state(now), .sends = told.sends};
            told_outputs_[i].output.stage = told.output.stage;
        }
    }
}

bool Engine::announce(std::size_t input, bool frame_came) {
    if (frame_came) {
        for (const std::size_t output : fed_by_[input]) {
            outputs_[output].frame_arrived(input, inputs_[input].arrivals());
            due_[output] = outputs_[output].due();
        }
    }
    return frame_came;
}

LinkState Engine::input_state(std::size_t input, Instant now) const {
    LinkState state = inputs_[input].state();
    const bool of_use =
        fed_by_[input].empty() || std::ranges::any_of(fed_by_[input], [&](std::size_t output) {
            return outputs_[output].could_use(input, now, inputs_);
        });
    if (state.cause == LinkCause::good && !of_use) {
        state.cause = LinkCause::unproved;
    }
    return state;
}

void Engine::add(Change change) {
    if (changes_ != nullptr) {
        changes_->add(change);
    }
}

LinkState Engine::tell_input(std::size_t input, Instant now) {
    const LinkState state = input_state(input, now);
    PartState& told = told_inputs_[input];
    if (state.cause != told.link.cause) {
        const PartState was = std::exchange(told, {.link = state});
        add({.at = now, .part = Change::Part::input, .index = input, .was = was, .now = told});
    }
    return state;
}

PartState Engine::state_of(std::size_t output, Instant now) const {
    return {.output = outputs_[output].state(now), .sends = outputs_[output].has_frames()};
}

OutputState Engine::tell_output(std::size_t output, Instant now) {
    const PartState fresh = state_of(output, now);
    PartState& told = told_outputs_[output];
    // Channels may be absent in one frame and present in the next.
    told.output.by_preset = fresh.output.by_preset;
    // Whoever removes an output or ends the program knows that it goes into failsafe.
    if ((fresh.output != told.output || fresh.sends != told.sends) && !outputs_[output].ends()) {
        const PartState was = std::exchange(told, fresh);
        add({.at = now, .part = Change::Part::output, .index = output, .was = was, .now = fresh});
    }
    return fresh.output;
}

void Engine::tell_node(std::size_t node, Instant now) {
    const dronecan::NodeState state = nodes_[node]->state();
    if (state != told_nodes_[node]) {
        const PartState was{.node = std::exchange(told_nodes_[node], state)};
        add({.at = now,
             .part = Change::Part::node,
             .index = node,
             .was = was,
             .now = {.node = state}});
    }
}

/// An input that an output takes is good, and nothing else tells that. An output that leaves
/// control looks further ahead than its input, which will be lost a period later or not at all.
void Engine::output_changed(std::size_t output, Instant now) {
    outputs_[output].look_at_stage(now);
    tell_output(output, now);
    for (const std::size_t input : outputs_[output].inputs()) {
        if (told_inputs_[input].link.cause == LinkCause::unproved) {
            tell_input(input, now);
        }
    }
}

void Engine::was_away(Instant since, Instant now) {
    for (Input& input : inputs_) {
        input.was_away(since, now);
    }
}

void Engine::watch_for_foreign_sender(std::size_t output, const CanFrame& frame, Instant at) {
    const auto ids = outputs_[output].sent_ids();
    if (std::ranges::any_of(ids, [&](const CanIdMatch& id) { return id.matches(frame); })) {
        outputs_[output].foreign_frame_seen(at);
    }
}

void Engine::set_lines(LineLevels levels, Instant now) {
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        outputs_[i].force_failsafe(line_roles_.forces(i, levels), now);
        outputs_[i].pick_input(line_roles_.picked(outputs_[i].inputs(), levels));
        outputs_[i].set_lines(levels);
    }
}

[[gnu::flatten]] Instant Engine::poll(Instant now) {
    Instant next = kNever;
    ran_.clear();
    for (std::size_t i = 0; i < due_.size(); ++i) {
        if (due_[i] <= now) {
            for (const std::size_t input : outputs_[i].inputs()) {
                inputs_[input].look(now);
            }
            outputs_[i].run(now, inputs_);
            due_[i] = outputs_[i].due();
            ran_.push_back(i);
        }
        next = std::min(next, due_[i]);
    }
    return nodes_.empty() ? next : std::min(next, poll_nodes(now));
}

Instant Engine::poll_nodes(Instant now) {
    Instant next = kNever;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        next = std::min(next, nodes_[i]->poll(now, health_of(i)));
        tell_node(i, now);
        const auto request = nodes_[i]->take_period_request();
        if (request) {
            outputs_[request->output].set_period(request->period);
        }
    }
    return next;
}

/// A node reports a warning while any of its outputs is not in control.
dronecan::NodeHealth Engine::health_of(std::size_t node) const {
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        if (node_of_[i] == node && outputs_[i].stage() != OutputStage::control) {
            return dronecan::NodeHealth::warning;
        }
    }
    return dronecan::NodeHealth::ok;
}

/// Returns when its last frames have been sent.
Instant Engine::end_output(std::size_t output, Instant now) {
    constexpr int kLastFrames = 3;
    constexpr Duration kMostOfAll = std::chrono::seconds(1);
    Output& ended = outputs_[output];
    ended.end(now);
    due_[output] = ended.due();
    if (ended.inputs().empty()) {
        // It sends fresh values only, and then nothing.
        return now;
    }
    const int frames = std::max(kLastFrames, ended.farewells());
    return later(now, std::min(frames * ended.period(), kMostOfAll));
}

Instant Engine::end(Instant now) {
    Instant until = now;
    for (const auto& node : nodes_) {
        node->end(now);
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        until = std::max(until, end_output(i, now));
    }
    return until;
}

Instant Engine::end(const Leaving& leaving, Instant now) {
    Instant until = now;
    for (const std::size_t node : leaving.nodes) {
        nodes_[node]->end(now);
    }
    for (const std::size_t output : leaving.outputs) {
        until = std::max(until, end_output(output, now));
    }
    return until;
}

}  // namespace tribus
