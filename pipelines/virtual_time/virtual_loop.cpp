#include "pipelines/virtual_time/virtual_loop.h"

#include <algorithm>

namespace tribus {

VirtualLoop::VirtualLoop(Engine& engine, StationObserver& observer, Instant start,
                         ValueEngine* values)
    : engine_(&engine), stations_(engine, values), observer_(observer), now_(start) {
    stations_.start(start);
    poll(start);
}

void VirtualLoop::send_ready(Instant at) {
    for (const Station& station : stations_.ready()) {
        for (Transmission sent = stations_.take(station, at); !sent.empty();
             sent = stations_.take(station, at)) {
            observer_.wrote(station, at, sent);
            stations_.handed_over(station, WriteStatus::written, at);
        }
    }
}

void VirtualLoop::poll(Instant at) {
    next_ = stations_.poll(at);
    send_ready(at);
    next_ = std::min(next_, stations_.poll_values(at));
    send_ready(at);
    observer_.polled(at);
    now_ = at;
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
    stations_ = Stations(next, values);
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
