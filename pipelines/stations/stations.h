#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"
#include "core/write_status.h"
#include "pipelines/engine/carry_over.h"
#include "pipelines/engine/engine.h"
#include "pipelines/stations/station.h"
#include "pipelines/values/value_engine.h"
#include "transports/codecs/frame_encoder.h"

namespace tribus {

/// All stations of a configuration. What drives them passes on what it reads, calls `poll` and
/// `poll_values`, and after each of the two sends what the stations in `ready` have. Owns nothing,
/// makes no system call, does not allocate after construction. Thread-bound.
class Stations {
  public:
    /// `values` is null if no sensor bus or value is configured. Both must outlive this.
    Stations(Engine& engine, ValueEngine* values);

    void start(Instant now);
    /// Call after `start`. The parts named in `carry` and `values` take over their state in
    /// `before`, which is unusable afterwards.
    void continue_from(Stations& before, const EngineCarry& carry, const ValueCarry& values,
                       Instant now);

    /// Takes undamaged bytes, read at `now`. Returns whether they completed a frame of an input.
    bool receive(Station station, std::span<const std::uint8_t> bytes, Instant now) {
        if (station.kind == StationKind::input) {
            return engine_->receive(station.index, bytes, now);
        }
        if (station.kind == StationKind::sensor_bus) {
            values_->receive(station.index, bytes, now);
        } else if (station.kind == StationKind::value_message) {
            values_->receive_message(station.index, bytes, now);
        } else if (station.kind == StationKind::replies) {
            engine_->hear(station.index, bytes, now);
        }
        return false;
    }
    /// The same for bytes with damage. `damaged[i]` is true if byte i was damaged on the line.
    template <class DamagedMarks>
    bool receive(Station station, std::span<const std::uint8_t> bytes, const DamagedMarks& damaged,
                 Instant now) {
        if (station.kind == StationKind::input) {
            return engine_->receive(station.index, bytes, damaged, now);
        }
        if (station.kind == StationKind::sensor_bus) {
            values_->receive(station.index, bytes, damaged, now);
        } else if (station.kind == StationKind::value_message) {
            values_->receive_message(station.index, bytes, damaged, now);
        } else if (station.kind == StationKind::replies) {
            for_undamaged_parts(
                bytes, damaged,
                [&](std::span<const std::uint8_t> part) {
                    engine_->hear(station.index, part, now);
                },
                [&] { engine_->forget_heard(station.index); });
        }
        return false;
    }
    /// See `Engine::datagram_ended`.
    bool datagram_ended(Station station, Instant now) {
        if (station.kind == StationKind::value_message || station.kind == StationKind::replies) {
            forget_unfinished(station);
        }
        return station.kind == StationKind::input && engine_->datagram_ended(station.index, now);
    }
    /// Takes a CAN frame of another node that arrived at `at`. Returns as above.
    bool receive(Station station, const CanFrame& frame, Instant at);
    /// The device is gone.
    void device_lost(Station station);
    /// Whether the device of an output is there. Other stations need not know.
    void set_device_present(Station station, bool present);
    /// Bytes that waited unread for this time or longer are of no use to a port with these
    /// stations: the shortest timeout of its inputs; without inputs, some periods of a sensor bus.
    Duration useful_for(std::span<const Station> on_port) const;
    /// Unread bytes were discarded.
    void bytes_discarded(Station station, Instant now);

    /// Runs every output and DroneCAN node that is due at `now`. Returns the time of the next call
    /// at the latest. Call it after `receive` too.
    Instant poll(Instant now) {
        const Instant next = engine_->poll(now);
        ready_.clear();
        for (const std::size_t output : engine_->ran()) {
            ready_.push_back({.kind = StationKind::output, .index = output});
        }
        for (std::size_t node = 0; node < engine_->node_count(); ++node) {
            ready_.push_back({.kind = StationKind::dronecan_node, .index = node});
        }
        return next;
    }
    /// The same for named values and sensor buses. Call it after `poll`, when what was ready has
    /// been sent: values may be facts about that.
    Instant poll_values(Instant now);
    /// The stations that may have something to send after the latest poll.
    std::span<const Station> ready() const { return ready_; }
    /// Takes its transmission. Empty if there is none, and after it was taken (a DroneCAN node:
    /// after `handed_over`, which makes its next transfer the first). Valid until the next poll.
    Transmission take(Station station, Instant now) {
        return station.kind == StationKind::output ? engine_->output(station.index).take()
                                                   : take_from_other(station, now);
    }
    /// Upper limit of the age of its transmission when the link takes it.
    Duration valid_for(Station station) const {
        return station.kind == StationKind::output ? engine_->outputs()[station.index].period()
                                                   : valid_for_other(station);
    }
    /// Tells it at `at` the outcome of the transmission that was taken.
    void handed_over(Station station, WriteStatus status, Instant at) {
        if (station.kind == StationKind::output && status == WriteStatus::written) {
            Output& output = engine_->output(station.index);
            if (output.sends()) {
                output.written();
            }
        } else {
            tell_outcome(station, status, at);
        }
    }

    /// A station of kind `answers` answers at `now` the sender of what was received last. Call it
    /// after `receive`, before anything else is received from the same port. Empty if there
    /// is nothing. Valid until the next call.
    Transmission answer(Station station, Instant now) {
        return engine_->answer(station.index, now);
    }

    bool on_can(Station station) const;
    /// Whether it needs CAN FD.
    bool uses_fd(Station station) const;
    /// The CAN ids that it receives, and those that it sends. Empty if it is not on CAN.
    std::span<const CanIdMatch> wanted_ids(Station station) const;
    std::span<const CanIdMatch> sent_ids(Station station) const;

  private:
    /// Discards a message that its bytes have begun: the rest will not come.
    void forget_unfinished(Station station);
    Transmission take_from_other(Station station, Instant now);
    Duration valid_for_other(Station station) const;
    void tell_outcome(Station station, WriteStatus status, Instant at);

    Engine* engine_;
    ValueEngine* values_;
    std::vector<Station> ready_;
};

}  // namespace tribus
