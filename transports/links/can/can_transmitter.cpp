#include "transports/links/can/can_transmitter.h"

#include <algorithm>
#include <cassert>

namespace tribus {

WriteStatus CanTransmitter::offer(std::size_t lane, std::span<const CanFrame> snapshot,
                                  Instant now) {
    const bool possible =
        lane < kMostLanes && !snapshot.empty() && snapshot.size() <= kMostSnapshotFrames;
    assert(possible);
    poll(now);
    if (!possible || down_ || stalled_) {
        return WriteStatus::unavailable;
    }
    if (bus_off_) {
        // A frame that the controller still holds is already a probe. A second one would form a
        // queue.
        if (in_flight_ || anything_pending() || now < probe_at_) {
            return WriteStatus::unavailable;
        }
        probe_at_ = later(now, kProbePeriod);
    }
    Lane& own = lanes_[lane];
    if (own.pending()) {
        if (own.begun()) {
            return WriteStatus::busy;
        }
        // The lane keeps its turn.
        ++counts_.abandoned;
    }
    std::ranges::copy(snapshot, own.frames.begin());
    own.count = snapshot.size();
    own.gone = 0;
    own.offered = now;
    return WriteStatus::written;
}

const CanFrame* CanTransmitter::next(Instant now) {
    poll(now);
    if (in_flight_ || down_ || now < retry_at_) {
        return nullptr;
    }
    // A snapshot is sent whole before the next lane has its turn, because its receiver waits for
    // all frames.
    for (std::size_t step = 0; step < kMostLanes; ++step) {
        const std::size_t lane = (serving_ + step) % kMostLanes;
        if (lanes_[lane].pending()) {
            serving_ = lane;
            return &lanes_[lane].frames[lanes_[lane].gone];
        }
    }
    return nullptr;
}

void CanTransmitter::handed(Instant now) {
    Lane& lane = lanes_[serving_];
    assert(lane.pending() && !in_flight_);
    in_flight_ = lane.frames[lane.gone];
    flight_since_ = now;
    flight_may_be_gone_ = false;
    full_ = false;
    full_long_ = false;
    ++lane.gone;
    ++counts_.sent;
    if (!lane.pending()) {
        end_turn();
    }
}

void CanTransmitter::refused_full(Instant now) {
    ++counts_.queue_full;
    full_ = true;
    retry_at_ = later(now, kFullRetry);
    if (full_long_) {
        abandon_all();
    }
}

void CanTransmitter::refused() {
    abandon(lanes_[serving_]);
}

void CanTransmitter::went_down() {
    if (!down_) {
        ++counts_.downs;
    }
    down_ = true;
    bus_off_ = false;
    full_ = false;
    full_long_ = false;
    level_ = ErrorLevel::active;
    forget_flight();
    abandon_all();
}

void CanTransmitter::came_up(Instant now) {
    if (down_) {
        down_ = false;
        bus_off_ = false;
        retry_at_ = later(now, kSettlingTime);
    }
}

void CanTransmitter::confirmed() {
    if (!in_flight_) {
        return;
    }
    ++counts_.confirmed;
    bus_off_ = false;
    forget_flight();
}

void CanTransmitter::forget_flight() {
    in_flight_.reset();
    stalled_ = false;
}

void CanTransmitter::bus_off(Instant now) {
    if (!bus_off_) {
        ++counts_.bus_offs;
        probe_at_ = later(now, kProbePeriod);
    }
    bus_off_ = true;
    stalled_ = false;
    abandon_all();
}

void CanTransmitter::restarted(Instant now) {
    bus_off_ = false;
    level_ = ErrorLevel::active;
    forget_flight();
    retry_at_ = later(now, kSettlingTime);
}

void CanTransmitter::alive(Instant now) {
    if (!bus_off_) {
        return;
    }
    // Some adapters recover by themselves and send the frame that they hold, others discard it.
    // Waits the usual time to find out.
    bus_off_ = false;
    flight_since_ = now;
    flight_may_be_gone_ = true;
}

void CanTransmitter::poll(Instant now) {
    const auto too_long = [now](Instant since) { return now >= later(since, kMostWait); };
    if (in_flight_ && !stalled_ && !bus_off_ && too_long(flight_since_)) {
        if (flight_may_be_gone_) {
            forget_flight();
        } else {
            stalled_ = true;
            ++counts_.stalls;
            abandon_all();
        }
    }
    for (Lane& lane : lanes_) {
        if (!lane.pending() || !too_long(lane.offered)) {
            continue;
        }
        abandon(lane);
        if (full_ && !full_long_) {
            full_long_ = true;
            ++counts_.stalls;
        }
    }
}

Instant CanTransmitter::due() const {
    Instant due = kNever;
    if (in_flight_ && !stalled_ && !bus_off_) {
        due = later(flight_since_, kMostWait);
    }
    for (const Lane& lane : lanes_) {
        if (lane.pending()) {
            due = std::min(due, later(lane.offered, kMostWait));
        }
    }
    if (!in_flight_ && !down_ && anything_pending()) {
        due = std::min(due, retry_at_);
    }
    return due;
}

CanBusState CanTransmitter::state() const {
    if (down_) {
        return CanBusState::down;
    }
    if (bus_off_) {
        return CanBusState::bus_off;
    }
    if (stalled_ || full_long_) {
        return CanBusState::stalled;
    }
    switch (level_) {
        case ErrorLevel::warning:
            return CanBusState::warning;
        case ErrorLevel::passive:
            return CanBusState::passive;
        case ErrorLevel::active:
            break;
    }
    return CanBusState::ready;
}

void CanTransmitter::abandon(Lane& lane) {
    if (!lane.pending()) {
        return;
    }
    // If the bus is too slow for all lanes, the lane that just had its turn does not begin again.
    if (lane.begun()) {
        end_turn();
    }
    ++counts_.abandoned;
    lane.gone = lane.count;
}

void CanTransmitter::end_turn() {
    serving_ = (serving_ + 1) % kMostLanes;
}

void CanTransmitter::abandon_all() {
    for (Lane& lane : lanes_) {
        abandon(lane);
    }
}

bool CanTransmitter::anything_pending() const {
    return std::ranges::any_of(lanes_, [](const Lane& lane) { return lane.pending(); });
}

}  // namespace tribus
