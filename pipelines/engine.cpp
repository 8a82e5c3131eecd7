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
}

void Engine::start(Instant now) {
    for (Output& output : outputs_) {
        output.start(now);
    }
}

void Engine::announce(std::size_t input) {
    for (Output& output : outputs_) {
        output.frame_arrived(input, inputs_[input].arrivals());
    }
}

void Engine::watch_for_foreign_sender(std::size_t output, const CanFrame& frame, Instant at) {
    const auto ids = outputs_[output].sent_ids();
    if (std::ranges::any_of(ids, [&](const CanIdMatch& id) { return id.matches(frame); })) {
        outputs_[output].foreign_frame_seen(at);
    }
}

Instant Engine::poll(Instant now) {
    Instant next = kNever;
    for (Output& output : outputs_) {
        if (output.due() <= now) {
            output.run(now, inputs_);
        }
        next = std::min(next, output.due());
    }
    return next;
}

Instant Engine::end(Instant now) {
    constexpr int kLastFrames = 3;
    Instant until = now;
    for (Output& output : outputs_) {
        output.end(now);
        until = std::max(until, later(now, kLastFrames * output.period()));
    }
    return until;
}

}  // namespace tribus
