#include <algorithm>

#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/loop.h"

namespace tribus {
namespace {

/// Half of a sensor's slot.
constexpr Duration kMostAnswerDelay = std::chrono::microseconds(3500);

}  // namespace

/// Runs and sends what is due in sensor buses and values. Returns when something will be due next.
Instant Loop::advance_values(Instant now) {
    if (settings_.values == nullptr) {
        return kNever;
    }
    ValueEngine& values = *settings_.values;
    const Instant next = values.poll(engine_, now);
    for (const ValueEngine::BusWrite& write : values.bus_writes()) {
        Port& port = ports_[bus_ports_[write.bus]];
        ByteLink* link = port.link ? port.link->as_bytes() : nullptr;
        clock_ = monotonic_now();
        // After that time nobody waits for the answer any more.
        const bool too_late = clock_ - now > kMostAnswerDelay;
        const WriteStatus status = link == nullptr ? WriteStatus::lost
                                   : too_late      ? WriteStatus::busy
                                                   : link->write(write.bytes);
        clock_ = monotonic_now();
        if (status == WriteStatus::written) {
            capture(port, Transmission(write.bytes), clock_);
            values.written(write.bus, clock_);
        } else {
            values.dropped(write.bus);
        }
        if (status == WriteStatus::lost && port.link) {
            lose(port);
        }
    }
    return next;
}

}  // namespace tribus
