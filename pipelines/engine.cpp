#include "pipelines/engine.h"

#include <algorithm>
#include <utility>

namespace tribus {

Engine::Engine(std::vector<InputSettings> inputs, std::vector<OutputSettings> outputs) {
    inputs_.reserve(inputs.size());
    for (InputSettings& settings : inputs) {
        inputs_.emplace_back(std::move(settings), static_cast<std::uint8_t>(inputs_.size()));
    }
    outputs_.reserve(outputs.size());
    for (OutputSettings& settings : outputs) {
        outputs_.emplace_back(std::move(settings));
    }
    fed_by_.resize(inputs_.size());
    for (std::size_t output = 0; output < outputs_.size(); ++output) {
        for (const std::size_t input : outputs_[output].inputs()) {
            fed_by_[input].push_back(output);
        }
    }
    due_.assign(outputs_.size(), kNever);
    ran_.reserve(outputs_.size());
}

void Engine::start(Instant now) {
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        outputs_[i].start(now);
        due_[i] = outputs_[i].due();
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

void Engine::watch_for_foreign_sender(std::size_t output, const CanFrame& frame, Instant at) {
    const auto ids = outputs_[output].sent_ids();
    if (std::ranges::any_of(ids, [&](const CanIdMatch& id) { return id.matches(frame); })) {
        outputs_[output].foreign_frame_seen(at);
    }
}

Instant Engine::poll(Instant now) {
    Instant next = kNever;
    ran_.clear();
    for (std::size_t i = 0; i < due_.size(); ++i) {
        if (due_[i] <= now) {
            outputs_[i].run(now, inputs_);
            due_[i] = outputs_[i].due();
            ran_.push_back(i);
        }
        next = std::min(next, due_[i]);
    }
    return next;
}

Instant Engine::end(Instant now) {
    constexpr int kLastFrames = 3;
    Instant until = now;
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        outputs_[i].end(now);
        due_[i] = outputs_[i].due();
        until = std::max(until, later(now, kLastFrames * outputs_[i].period()));
    }
    return until;
}

}  // namespace tribus
