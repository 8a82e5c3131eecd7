#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/loop.h"

/// Writes what outputs, DroneCAN nodes and sensor buses have to send.
namespace tribus {
namespace {

/// Half of a sensor's slot: after that time nobody waits for the answer of a sensor bus any more.
constexpr Duration kMostAnswerDelay = std::chrono::microseconds(3500);
/// Messages of a node say themselves how old they may be.
constexpr Duration kAnyDelay = Duration::max();

void tell(Output& output, WriteStatus status) {
    switch (status) {
        case WriteStatus::written:
            output.written();
            break;
        case WriteStatus::busy:
            output.dropped_busy();
            break;
        case WriteStatus::unavailable:
            output.dropped_unavailable();
            break;
        case WriteStatus::lost:
            output.dropped_lost();
            break;
    }
}

void tell(dronecan::Node& node, WriteStatus status, Instant now) {
    switch (status) {
        case WriteStatus::written:
            node.written();
            break;
        case WriteStatus::busy:
            node.busy(now);
            break;
        case WriteStatus::unavailable:
        case WriteStatus::lost:
            node.dropped();
            break;
    }
}

void tell(ValueEngine& values, std::size_t bus, WriteStatus status, Instant at) {
    if (status == WriteStatus::written) {
        values.written(bus, at);
    } else {
        values.dropped(bus);
    }
}

}  // namespace

/// Drops what was made at `now` as stale if it is older than `valid_for` when the link takes it.
WriteStatus Loop::hand_over(Link& link, std::size_t lane, const Transmission& sent,
                            Duration valid_for, Instant now) {
    ByteLink* bytes = link.as_bytes();
    const WriteStatus asked = bytes != nullptr ? bytes->ask() : WriteStatus::written;
    clock_ = monotonic_now();
    if (asked != WriteStatus::written) {
        return asked;
    }
    if (clock_ - now > valid_for) {
        return WriteStatus::busy;
    }
    return bytes != nullptr ? bytes->write_asked(sent.bytes())
                            : link.as_can()->write(lane, sent.can_frames(), clock_);
}

void Loop::capture(const Port& port, const Transmission& sent, Instant at) {
    if (port.wiring.capture == nullptr) {
        return;
    }
    port.wiring.capture->record(sent.bytes(), at);
    for (const CanFrame& frame : sent.can_frames()) {
        port.wiring.capture->record(Direction::written, frame, at);
    }
}

/// Every sender uses this function. Calls `told` with the result before it gives up a lost port.
template <class Told>
void Loop::send(Port& port, std::size_t lane, const Transmission& sent, Duration valid_for,
                Instant now, Told told) {
    const WriteStatus status =
        port.link ? hand_over(*port.link, lane, sent, valid_for, now) : WriteStatus::lost;
    clock_ = monotonic_now();
    told(status);
    if (status == WriteStatus::written) {
        capture(port, sent, clock_);
    } else if (status == WriteStatus::lost && port.link) {
        lose(port);
    }
}

void Loop::note_sent(std::size_t index, const Output& output, Instant now) {
    output_timing_[index]->frame_went({.due = output.latest_due(),
                                       .taken = now,
                                       .handed_over = clock_,
                                       .read = output.latest().received,
                                       .period = output.period()});
    if (settings_.lines != nullptr && is_fresh(output, clock_)) {
        settings_.lines->set_fresh(index, clock_);
    }
}

void Loop::write_outputs(Instant now) {
    for (const std::size_t index : engine_.ran()) {
        Output& output = engine_.output(index);
        const Transmission sent = output.take();
        if (sent.empty()) {
            continue;
        }
        const auto [port, lane] = routes_[index];
        send(ports_[port], lane, sent, output.period(), now, [&](WriteStatus status) {
            tell(output, status);
            if (status == WriteStatus::written) {
                note_sent(index, output, now);
            }
        });
    }
}

/// DroneCAN nodes send in a lane of their own, after the outputs of the interface.
void Loop::write_nodes(Instant now) {
    for (const std::size_t index : can_ports_) {
        Port& port = ports_[index];
        if (!port.wiring.node) {
            continue;
        }
        dronecan::Node& node = engine_.node(*port.wiring.node);
        const auto frames = node.frames_to_send(now);
        if (!frames.empty()) {
            send(port, port.wiring.outputs.size(), Transmission(frames), kAnyDelay, now,
                 [&](WriteStatus status) { tell(node, status, now); });
        }
    }
}

void Loop::write_buses(Instant now) {
    ValueEngine& values = *settings_.values;
    for (const ValueEngine::BusWrite& write : values.bus_writes()) {
        send(ports_[bus_ports_[write.bus]], 0, Transmission(write.bytes), kMostAnswerDelay, now,
             [&](WriteStatus status) { tell(values, write.bus, status, clock_); });
    }
}

}  // namespace tribus
