#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/loop.h"

/// Writes what the stations have to send.
namespace tribus {

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
    return bytes != nullptr
               ? bytes->write_asked(sent.bytes(), {.made = now, .valid_for = valid_for})
               : link.as_can()->write(lane, sent.can_frames(), clock_);
}

void Loop::capture(const PortWiring& wiring, const Transmission& sent, Instant at) {
    wiring.capture->record(sent.bytes(), at);
    for (const CanFrame& frame : sent.can_frames()) {
        wiring.capture->record(Direction::written, frame, at);
    }
}

void Loop::note_sent(std::size_t index, Instant now) {
    const Output& output = engine_.outputs()[index];
    output_timing_[index]->frame_went({.due = output.latest_due(),
                                       .taken = now,
                                       .handed_over = clock_,
                                       .read = output.latest().received,
                                       .period = output.period()});
    if (settings_.lines != nullptr && is_fresh(output, clock_)) {
        settings_.lines->set_fresh(index, clock_);
    }
}

/// A lost port is given up last: its stations then hear that the device is gone.
void Loop::send(Station station, const Transmission& sent, Instant now) {
    const auto [place, lane] = routes_[static_cast<std::size_t>(station.kind)][station.index];
    Port& port = ports_[place];
    const WriteStatus status =
        port.link ? hand_over(*port.link, lane, sent, stations_.valid_for(station), now)
                  : WriteStatus::lost;
    clock_ = monotonic_now();
    stations_.handed_over(station, status, clock_);
    if (status == WriteStatus::written) {
        if (station.kind == StationKind::output && engine_.outputs()[station.index].sends()) {
            note_sent(station.index, now);
        }
        if (port.wiring.capture != nullptr) {
            capture(port.wiring, sent, clock_);
        }
    } else if (status == WriteStatus::lost && port.link) {
        lose(port);
    }
}

void Loop::send_ready(Instant now) {
    for (const Station& station : stations_.ready()) {
        const Transmission sent = stations_.take(station, now);
        if (!sent.empty()) {
            send(station, sent, now);
        }
    }
}

}  // namespace tribus
