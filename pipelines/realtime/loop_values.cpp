#include <algorithm>

#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/loop.h"

namespace tribus {

/// Runs what is due of sensor buses and values, and sends it; returns when something will be.
Instant Loop::advance_values(Instant now) {
    if (settings_.values == nullptr) {
        return kNever;
    }
    ValueEngine& values = *settings_.values;
    const Instant next = values.poll(engine_, now);
    for (const ValueEngine::Speech& speech : values.speeches()) {
        Port& port = ports_[bus_ports_[speech.bus]];
        ByteLink* link = port.link ? port.link->as_bytes() : nullptr;
        const WriteStatus status = link == nullptr ? WriteStatus::lost : link->write(speech.bytes);
        clock_ = monotonic_now();
        if (status == WriteStatus::written) {
            capture(port, {.bytes = speech.bytes, .can_frames = {}}, clock_);
            values.written(speech.bus, clock_);
        } else {
            values.dropped(speech.bus);
        }
        if (status == WriteStatus::lost && port.link) {
            lose(port);
        }
    }
    return next;
}

}  // namespace tribus
