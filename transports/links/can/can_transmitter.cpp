#include "transports/links/can/can_transmitter.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/links/can/can_wire.h"

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
        if (in_flight() || pending_ != 0 || now < probe_at_) {
            return WriteStatus::unavailable;
        }
        probe_at_ = later(now, kProbePeriod);
    }
    Lane& own = lanes_[lane];
    if (pending(lane)) {
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
    pending_ |= Set{1} << lane;
    return WriteStatus::written;
}

std::span<const CanFrame> CanTransmitter::next(Instant now) {
    poll(now);
    if (in_flight() || pending_ == 0 || now < retry_at_) {
        return {};
    }
    // A snapshot is sent whole before the next lane has its turn, because its receiver waits for
    // all frames.
    const Set from_serving = pending_ >> serving_ << serving_;
    const Set candidates = from_serving != 0 ? from_serving : pending_;
    serving_ = static_cast<std::size_t>(std::countr_zero(candidates));
    const Lane& lane = lanes_[serving_];
    const bool alone = (careful_ || !confirms_) && !lane.begun();
    return std::span(lane.frames).subspan(lane.gone, alone ? 1 : lane.count - lane.gone);
}

void CanTransmitter::handed(std::size_t count, Instant now) {
    Lane& lane = lanes_[serving_];
    assert(!in_flight() && count > 0 && count <= lane.count - lane.gone);
    std::copy_n(lane.frames.begin() + static_cast<std::ptrdiff_t>(lane.gone), count,
                flight_.begin());
    in_flight_ = (Set{1} << count) - 1;
    flight_since_ = now;
    flight_may_be_gone_ = false;
    full_ = false;
    full_long_ = false;
    lane.gone += count;
    counts_.sent += count;
    if (lane.gone == lane.count) {
        pending_ &= ~(Set{1} << serving_);
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
    assert(pending(serving_));
    abandon(serving_);
}

void CanTransmitter::went_down() {
    if (!down_) {
        ++counts_.downs;
    }
    down_ = true;
    full_ = false;
    full_long_ = false;
    careful_ = true;
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

void CanTransmitter::confirmed(const CanFrame& frame, Instant now) {
    for (Set left = in_flight_; left != 0; left &= left - 1) {
        const auto place = static_cast<std::size_t>(std::countr_zero(left));
        if (same_message(flight_[place], frame)) {
            ++counts_.confirmed;
            flight_since_ = now;
            in_flight_ &= ~(Set{1} << place);
            bus_works();
            return;
        }
    }
}

void CanTransmitter::confirmed_all() {
    if (in_flight()) {
        counts_.confirmed += static_cast<std::uint64_t>(std::popcount(in_flight_));
        in_flight_ = 0;
        bus_works();
    }
}

void CanTransmitter::bus_works() {
    bus_off_ = false;
    stalled_ = false;
    if (!in_flight()) {
        careful_ = level_ != ErrorLevel::active;
    }
}

void CanTransmitter::forget_flight() {
    in_flight_ = 0;
    stalled_ = false;
}

void CanTransmitter::bus_off(Instant now) {
    if (!bus_off_) {
        ++counts_.bus_offs;
        probe_at_ = later(now, kProbePeriod);
    }
    bus_off_ = true;
    stalled_ = false;
    careful_ = true;
    abandon_all();
}

void CanTransmitter::restarted(Instant now) {
    bus_off_ = false;
    level_ = ErrorLevel::active;
    forget_flight();
    retry_at_ = later(now, kSettlingTime);
}

void CanTransmitter::error_level(ErrorLevel level) {
    level_ = level;
    careful_ = careful_ || level != ErrorLevel::active;
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
    if (in_flight() && !stalled_ && !bus_off_ && too_long(flight_since_)) {
        careful_ = true;
        if (flight_may_be_gone_) {
            forget_flight();
        } else {
            stalled_ = true;
            ++counts_.stalls;
            abandon_all();
        }
    }
    for (Set left = pending_; left != 0; left &= left - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(left));
        if (!too_long(lanes_[lane].offered)) {
            continue;
        }
        abandon(lane);
        if (full_ && !full_long_) {
            full_long_ = true;
            careful_ = true;
            ++counts_.stalls;
        }
    }
}

Instant CanTransmitter::due() const {
    Instant due = kNever;
    if (in_flight() && !stalled_ && !bus_off_) {
        due = later(flight_since_, kMostWait);
    }
    for (Set left = pending_; left != 0; left &= left - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(left));
        due = std::min(due, later(lanes_[lane].offered, kMostWait));
    }
    if (!in_flight() && pending_ != 0) {
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

void CanTransmitter::abandon(std::size_t lane) {
    // If the bus is too slow for all lanes, the lane that just had its turn does not begin again.
    if (lanes_[lane].begun()) {
        end_turn();
    }
    ++counts_.abandoned;
    pending_ &= ~(Set{1} << lane);
}

void CanTransmitter::end_turn() {
    serving_ = (serving_ + 1) % kMostLanes;
}

void CanTransmitter::abandon_all() {
    for (Set left = pending_; left != 0; left &= left - 1) {
        abandon(static_cast<std::size_t>(std::countr_zero(left)));
    }
}

}  // namespace tribus
