#include <algorithm>
#include <chrono>
#include <cstddef>
#include <utility>

#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/loop.h"

/// Reads from the ports into the engine, also after the thread did not run for a while.
namespace tribus {
namespace {

/// Capacity of a terminal's line buffer (N_TTY_BUF_SIZE, of which one byte stays free). Bytes that
/// the kernel holds beyond it become readable only some time after a read.
constexpr std::size_t kLineBufferBytes = 4095;
/// The default timeout of an input. A shorter absence is not reported.
constexpr Duration kToldAbsence = std::chrono::milliseconds(100);
constexpr Duration kSilentPortPeriod = std::chrono::seconds(1);

}  // namespace

/// Publishes its time at once: with a figure that is up to 100 ms old, ages would be wrong by that
/// much.
void Loop::note_frame(std::size_t input, Instant at) {
    input_timing_[input]->frame_came(at);
    newest_at_ns_[input].store(engine_.inputs()[input].latest().received.time_since_epoch().count(),
                               std::memory_order_relaxed);
}

/// Passes on the latest reception as read at `at`. Returns whether it completed a frame.
bool Loop::hand_on_bytes(const PortWiring& wiring, Instant at) {
    if (wiring.capture != nullptr) {
        wiring.capture->record(reception_, at);
    }
    bool frame_came = false;
    const bool clean = reception_.damaged.none();
    for (const Station& station : wiring.stations) {
        const bool came =
            clean ? stations_.receive(station, reception_.view(), at)
                  : stations_.receive(station, reception_.view(), reception_.damaged, at);
        if (came) {
            note_frame(station.index, at);
            frame_came = true;
        }
    }
    if (wiring.has_datagrams && !reception_.goes_on) {
        frame_came = end_datagram(wiring, at) || frame_came;
    }
    return frame_came;
}

/// Returns whether the end completed a frame.
bool Loop::end_datagram(const PortWiring& wiring, Instant at) {
    bool frame_came = false;
    for (const Station& station : wiring.stations) {
        if (stations_.datagram_ended(station, at)) {
            note_frame(station.index, at);
            frame_came = true;
        }
    }
    return frame_came;
}

[[gnu::noinline]] void Loop::answer(const PortWiring& wiring, Link& link, Instant now) {
    for (const Station& station : wiring.stations) {
        if (station.kind != StationKind::answers) {
            continue;
        }
        const Transmission sent = stations_.answer(station, now);
        if (sent.empty()) {
            continue;
        }
        const auto lane = routes_[static_cast<std::size_t>(station.kind)][station.index].lane;
        const WriteStatus status = hand_over(link, lane, sent, Duration::max(), now);
        if (status == WriteStatus::written && wiring.capture != nullptr) {
            capture(wiring, sent, clock_);
        }
    }
}

/// More than one read is needed only after a delay. Then the newest frame counts.
ReadStatus Loop::read_bytes(std::size_t index, ByteLink& link, Instant now) {
    Port& port = ports_[index];
    std::size_t bytes = 0;
    bool frame_came = false;
    int fruitless = 0;
    ReadStatus status = ReadStatus::received;
    reception_.full = true;
    reception_.goes_on = false;
    reception_.at = kNever;
    for (int reads = 0;
         (reads < kMostReads && fruitless < kMostFruitlessReads && reception_.full) ||
         reception_.goes_on;
         ++reads) {
        status = link.read(reception_);
        if (status != ReadStatus::received) {
            break;
        }
        bytes += reception_.count;
        const bool comes = hand_on_bytes(port.wiring, std::min(now, reception_.at));
        fruitless = comes ? 0 : fruitless + 1;
        frame_came = comes || frame_came;
        // At once, because a datagram link answers the sender of the latest datagram.
        if (port.wiring.answers && !reception_.goes_on) {
            answer(port.wiring, link, now);
        }
    }
    if (bytes == 0) {
        return status;
    }
    Instant read_next = port.pacer.delivered(bytes, frame_came, now);
    if (fruitless >= kMostFruitlessReads) {
        read_next = now + kFruitlessPause;
    }
    if (read_next > now && status == ReadStatus::received) {
        set_watched(index, false);
        port.quiet_until = read_next;
        ++quiet_ports_;
    }
    return status;
}

void Loop::hand_on_can(const PortWiring& wiring) {
    for (const ReceivedCanFrame& received : can_reception_.view()) {
        if (wiring.capture != nullptr) {
            wiring.capture->record(Direction::read, received.frame, received.at);
        }
        for (const Station& station : wiring.stations) {
            if (stations_.receive(station, received.frame, received.at)) {
                note_frame(station.index, received.at);
            }
        }
    }
}

/// CAN frames carry their own times, so the time of the read matters little.
[[gnu::noinline]] ReadStatus Loop::read_can(const PortWiring& wiring, CanLink& link, Instant now) {
    ReadStatus status = ReadStatus::nothing;
    can_reception_.full = true;
    for (int reads = 0; reads < kMostReads && can_reception_.full; ++reads) {
        status = link.read(can_reception_, now, wall_time_now());
        hand_on_can(wiring);
    }
    can_answers_wait_ = can_answers_wait_ || wiring.answers;
    return status;
}

/// After what the received frames let the outputs send: that is what must be quick.
[[gnu::noinline]] void Loop::answer_can_frames(Instant now) {
    can_answers_wait_ = false;
    for (const std::size_t index : can_ports_) {
        Port& port = ports_[index];
        if (port.wiring.answers && port.link) {
            answer(port.wiring, *port.link, now);
        }
    }
}

void Loop::end_quiet(std::size_t index) {
    Port& port = ports_[index];
    if (port.quiet_until != kNever) {
        port.quiet_until = kNever;
        --quiet_ports_;
        set_watched(index, true);
    }
}

void Loop::read_port(std::size_t index, Instant now) {
    Port& port = ports_[index];
    if (!port.link) {
        return;
    }
    port.reported = true;
    end_quiet(index);
    ByteLink* bytes = port.link->as_bytes();
    const ReadStatus status = bytes != nullptr ? read_bytes(index, *bytes, now)
                                               : read_can(port.wiring, *port.link->as_can(), now);
    if (status == ReadStatus::lost) {
        lose(port);
    } else if (bytes != nullptr && reception_.full) {
        watch_again(index);
    }
}

/// Reads what came at a port unreported since `since`. Returns whether anything did.
bool Loop::read_unreported(Port& port, Instant since, Instant now) {
    if (CanLink* can = port.link->as_can()) {
        const ReadStatus status = read_can(port.wiring, *can, now);
        if (status == ReadStatus::lost) {
            lose(port);
        }
        return status == ReadStatus::received;
    }
    ByteLink& link = *port.link->as_bytes();
    bool came = false;
    reception_.goes_on = false;
    reception_.at = kNever;
    for (int reads = 0; (reads < kMostFruitlessReads || reception_.goes_on) && link.has_unread();
         ++reads) {
        const ReadStatus status = link.read(reception_);
        if (status == ReadStatus::lost) {
            lose(port);
        }
        if (status != ReadStatus::received) {
            break;
        }
        came = true;
        // It may be as old as that, so it never passes for new.
        hand_on_bytes(port.wiring, std::min(since, reception_.at));
    }
    return came;
}

/// A port may be silent because its sender is, or because the kernel does not report what comes.
/// Once a second a look that nobody asked for finds out.
[[gnu::noinline]] void Loop::look_at_silent_ports(Instant now) {
    if (now - looked_at_ports_ < kSilentPortPeriod) {
        return;
    }
    const Instant since = std::exchange(looked_at_ports_, now);
    if (since == Instant{}) {
        return;
    }
    for (Port& port : ports_) {
        const bool reads = port.link && port.link->descriptor() >= 0 &&
                           (port.link->as_can() != nullptr || wants_bytes(port.wiring.stations));
        const bool caught_up = std::exchange(port.caught_up, false);
        if (!reads || std::exchange(port.reported, false) || port.quiet_until != kNever) {
            port.unheard = 0;
        } else if (!caught_up) {
            port.unheard = read_unreported(port, since, now) ? port.unheard + 1 : 0;
        }
    }
    publish_standing_port(now);
}

[[gnu::noinline]] void Loop::read_quiet_ports(Instant now) {
    for (std::size_t port = 0; quiet_ports_ > 0 && port < ports_.size(); ++port) {
        if (ports_[port].quiet_until <= now) {
            read_port(port, now);
        }
    }
}

/// Reads every waiting byte. It may have come at any time since `since`.
ReadStatus Loop::catch_up_on_bytes(const PortWiring& wiring, ByteLink& link, Instant since,
                                   Instant now) {
    ReadStatus status = ReadStatus::received;
    std::size_t bytes = 0;
    bool discards = now - since >= stations_.useful_for(wiring.stations);
    reception_.full = false;
    reception_.goes_on = false;
    reception_.at = kNever;
    for (int reads = 0; !discards && (reads < kMostReads || reception_.goes_on); ++reads) {
        status = link.read(reception_);
        if (status != ReadStatus::received) {
            break;
        }
        bytes += reception_.count;
        hand_on_bytes(wiring, std::min(since, reception_.at));
        discards = bytes >= kLineBufferBytes;
    }
    if (discards) {
        link.discard_unread();
        for (const Station& station : wiring.stations) {
            stations_.bytes_discarded(station, now);
        }
    }
    return status;
}

/// Call after the thread did not run from `since` to `now`. Empties every port, ready or not, so
/// that no later read takes old bytes for new ones.
[[gnu::noinline]] void Loop::catch_up(Instant since, Instant now) {
    if (late_by_ >= kToldAbsence) {
        ++absence_.count;
        absence_.latest = late_by_;
    }
    for (std::size_t index = 0; index < ports_.size(); ++index) {
        Port& port = ports_[index];
        if (!port.link) {
            continue;
        }
        port.caught_up = true;
        end_quiet(index);
        ReadStatus status = ReadStatus::nothing;
        if (CanLink* can = port.link->as_can()) {
            status = read_can(port.wiring, *can, now);
        } else if (wants_bytes(port.wiring.stations)) {
            status = catch_up_on_bytes(port.wiring, *port.link->as_bytes(), since, now);
            if (reception_.full) {
                watch_again(index);
            }
        }
        if (status == ReadStatus::lost) {
            lose(port);
        }
    }
    engine_.was_away(since, now);
}

}  // namespace tribus
