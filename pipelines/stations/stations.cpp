#include "pipelines/stations/stations.h"

#include <algorithm>
#include <chrono>

namespace tribus {
namespace {

/// Less than half of a slot of 7.7 ms (docs/protocols/ibus.md): after that time nobody waits for
/// the answer of a sensor bus any more.
constexpr Duration kMostAnswerDelay = std::chrono::microseconds(3500);
/// Several periods of requests.
constexpr Duration kUsefulOnBus = std::chrono::milliseconds(50);
/// Messages of a DroneCAN node say themselves how old they may be.
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

void tell(dronecan::Node& node, WriteStatus status, Instant at) {
    switch (status) {
        case WriteStatus::written:
            node.written();
            break;
        case WriteStatus::busy:
            node.busy(at);
            break;
        case WriteStatus::unavailable:
        case WriteStatus::lost:
            node.dropped();
            break;
    }
}

}  // namespace

Stations::Stations(Engine& engine, ValueEngine* values) : engine_(&engine), values_(values) {
    ready_.reserve(engine.outputs().size() + engine.node_count() +
                   (values == nullptr ? 0 : values->bus_count()));
}

void Stations::start(Instant now) {
    engine_->start(now);
    if (values_ != nullptr) {
        values_->start(now);
    }
}

void Stations::continue_from(Stations& before, const EngineCarry& carry, const ValueCarry& values,
                             Instant now) {
    engine_->continue_from(*before.engine_, carry, now);
    if (values_ != nullptr && before.values_ != nullptr) {
        values_->continue_from(*before.values_, values, carry);
    }
}

bool Stations::receive(Station station, const CanFrame& frame, Instant at) {
    switch (station.kind) {
        case StationKind::input:
            return engine_->receive(station.index, frame, at);
        case StationKind::output:
            engine_->watch_for_foreign_sender(station.index, frame, at);
            break;
        case StationKind::dronecan_node:
            engine_->node(station.index).receive(frame, at);
            break;
        case StationKind::value_message:
            values_->receive(station.index, frame, at);
            break;
        case StationKind::replies:
            engine_->hear(station.index, frame, at);
            break;
        case StationKind::sensor_bus:
        case StationKind::answers:
            break;
    }
    return false;
}

void Stations::forget_unfinished(Station station) {
    if (station.kind == StationKind::value_message) {
        values_->message_lost(station.index);
    } else if (station.kind == StationKind::replies) {
        engine_->forget_heard(station.index);
    }
}

void Stations::device_lost(Station station) {
    if (station.kind == StationKind::input) {
        engine_->device_lost(station.index);
    } else if (station.kind == StationKind::sensor_bus) {
        values_->device_lost(station.index);
    } else {
        forget_unfinished(station);
    }
    set_device_present(station, false);
}

void Stations::set_device_present(Station station, bool present) {
    if (station.kind == StationKind::output) {
        engine_->output(station.index).set_device_present(present);
    }
}

Duration Stations::useful_for(std::span<const Station> on_port) const {
    Duration shortest = kAnyDelay;
    for (const Station& station : on_port) {
        if (station.kind == StationKind::input) {
            shortest = std::min(shortest, engine_->inputs()[station.index].link().timeout());
        }
    }
    return shortest == kAnyDelay ? kUsefulOnBus : shortest;
}

void Stations::bytes_discarded(Station station, Instant now) {
    if (station.kind == StationKind::input) {
        engine_->bytes_discarded(station.index);
    } else if (station.kind == StationKind::sensor_bus) {
        values_->bytes_discarded(station.index, now);
    } else {
        forget_unfinished(station);
    }
}

Instant Stations::poll_values(Instant now) {
    ready_.clear();
    if (values_ == nullptr) {
        return kNever;
    }
    const Instant next = values_->poll(*engine_, now);
    for (const std::size_t bus : values_->ran()) {
        ready_.push_back({.kind = StationKind::sensor_bus, .index = bus});
    }
    return next;
}

Transmission Stations::take_from_other(Station station, Instant now) {
    switch (station.kind) {
        case StationKind::dronecan_node:
            return Transmission(engine_->node(station.index).frames_to_send(now));
        case StationKind::sensor_bus:
            return values_->take(station.index);
        case StationKind::input:
        case StationKind::output:
        case StationKind::value_message:
        case StationKind::replies:
        case StationKind::answers:
            break;
    }
    return {};
}

Duration Stations::valid_for_other(Station station) const {
    return station.kind == StationKind::sensor_bus ? kMostAnswerDelay : kAnyDelay;
}

void Stations::tell_outcome(Station station, WriteStatus status, Instant at) {
    if (station.kind == StationKind::output) {
        tell(engine_->output(station.index), status);
    } else if (station.kind == StationKind::dronecan_node) {
        tell(engine_->node(station.index), status, at);
    } else if (status == WriteStatus::written) {
        values_->written(station.index, at);
    } else {
        values_->dropped(station.index);
    }
}

bool Stations::on_can(Station station) const {
    switch (station.kind) {
        case StationKind::input:
            return engine_->inputs()[station.index].on_can();
        case StationKind::output:
            return engine_->outputs()[station.index].on_can();
        case StationKind::dronecan_node:
            return true;
        case StationKind::value_message:
            return values_->on_can(station.index);
        case StationKind::replies:
            return engine_->outputs()[station.index].on_can();
        case StationKind::answers:
            return engine_->inputs()[station.index].on_can();
        case StationKind::sensor_bus:
            break;
    }
    return false;
}

bool Stations::uses_fd(Station station) const {
    switch (station.kind) {
        case StationKind::input:
            return engine_->inputs()[station.index].uses_fd();
        case StationKind::output:
            return engine_->outputs()[station.index].uses_fd();
        case StationKind::value_message:
            return values_->uses_fd(station.index);
        case StationKind::dronecan_node:
        case StationKind::sensor_bus:
        case StationKind::replies:
        case StationKind::answers:
            break;
    }
    return false;
}

std::span<const CanIdMatch> Stations::wanted_ids(Station station) const {
    switch (station.kind) {
        case StationKind::input:
            return engine_->inputs()[station.index].wanted_ids();
        case StationKind::dronecan_node:
            return engine_->node(station.index).wanted();
        case StationKind::value_message:
            return values_->wanted_ids(station.index);
        case StationKind::replies:
            return engine_->outputs()[station.index].heard_ids();
        case StationKind::output:
        case StationKind::sensor_bus:
        case StationKind::answers:
            break;
    }
    return {};
}

std::span<const CanIdMatch> Stations::sent_ids(Station station) const {
    if (station.kind == StationKind::answers) {
        return engine_->inputs()[station.index].answered_ids();
    }
    return station.kind == StationKind::output ? engine_->outputs()[station.index].sent_ids()
                                               : std::span<const CanIdMatch>();
}

}  // namespace tribus
