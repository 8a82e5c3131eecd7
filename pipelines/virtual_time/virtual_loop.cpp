#include "pipelines/virtual_time/virtual_loop.h"

#include <algorithm>

namespace tribus {

VirtualLoop::VirtualLoop(Engine& engine, OutputObserver& observer, Instant start,
                         ValueEngine* values)
    : engine_(&engine), observer_(observer), values_(values), now_(start) {
    engine_->start(start);
    if (values_ != nullptr) {
        values_->start(start);
    }
    poll(start);
}

void VirtualLoop::poll(Instant at) {
    next_ = engine_->poll(at);
    for (const std::size_t output : engine_->ran()) {
        const Transmission sent = engine_->output(output).take();
        if (!sent.empty()) {
            engine_->output(output).written();
            observer_.wrote(output, at, sent);
        }
    }
    for (std::size_t node = 0; node < engine_->node_count(); ++node) {
        for (auto frames = engine_->node(node).frames_to_send(at); !frames.empty();
             frames = engine_->node(node).frames_to_send(at)) {
            observer_.node_wrote(node, at, frames);
            engine_->node(node).written();
        }
    }
    next_ = std::min(next_, poll_values(at));
    observer_.polled(at);
    now_ = at;
}

Instant VirtualLoop::poll_values(Instant at) {
    if (values_ == nullptr) {
        return kNever;
    }
    const Instant next = values_->poll(*engine_, at);
    for (const ValueEngine::BusWrite& write : values_->bus_writes()) {
        observer_.bus_wrote(write.bus, at, write.bytes);
        values_->written(write.bus, at);
    }
    return next;
}

void VirtualLoop::run_until(Instant until) {
    while (next_ < until) {
        poll(std::max(next_, now_));
    }
    now_ = std::max(now_, until);
}

void VirtualLoop::come_back(Instant since, Instant until) {
    engine_->was_away(since, until);
    poll(until);
}

void VirtualLoop::go_on_with(Engine& next, ValueEngine* values, Instant at) {
    engine_ = &next;
    values_ = values;
    poll(at);
}

Instant VirtualLoop::retire(const Leaving& leaving, Instant at) {
    run_until(at);
    const Instant until = engine_->end(leaving, at);
    poll(at);
    return until;
}

void VirtualLoop::end(Instant at) {
    run_until(at);
    const Instant until = engine_->end(at);
    poll(at);
    run_until(until);
}

}  // namespace tribus
