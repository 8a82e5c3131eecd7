#include "pipelines/virtual_loop.h"

#include <algorithm>

namespace tribus {

VirtualLoop::VirtualLoop(Engine& engine, OutputObserver& observer, Instant start)
    : engine_(engine), observer_(observer), now_(start) {
    engine_.start(start);
    poll(start);
}

void VirtualLoop::poll(Instant at) {
    next_ = engine_.poll(at);
    for (const std::size_t output : engine_.ran()) {
        const Transmission sent = engine_.output(output).take();
        if (!sent.empty()) {
            engine_.output(output).written();
            observer_.wrote(output, at, sent);
        }
    }
    now_ = at;
}

void VirtualLoop::run_until(Instant until) {
    while (next_ < until) {
        poll(std::max(next_, now_));
    }
    now_ = std::max(now_, until);
}

void VirtualLoop::end(Instant at) {
    run_until(at);
    const Instant until = engine_.end(at);
    poll(at);
    run_until(until);
}

}  // namespace tribus
