#include <atomic>
#include <cstddef>
#include <utility>

#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/loop.h"

/// Replaces one loop by another between two frames. The data thread does bounded work here and
/// neither allocates nor closes anything: what is left stays in the loop before, which the main
/// thread destroys.
namespace tribus {

void Loop::retire(Leaving leaving) {
    leaving_ = std::move(leaving);
    retire_requested_.store(true, std::memory_order_release);
    set_event(waits_.wake_up());
}

void Loop::hand_over_to(Loop& next, LoopCarry carry) {
    next.carry_ = std::move(carry);
    next.waits_.make_room(waits_);
    // A running data thread takes this event over as soon as it sees `next`.
    const int event = waits_.wake_up();
    successor_.store(&next, std::memory_order_release);
    set_event(event);
}

void Loop::discard_unread() {
    for (Port& port : ports_) {
        if (port.link) {
            discard_unread_of(*port.link, monotonic_now());
        }
    }
}

Loop* Loop::successor(Instant now) {
    if (!retiring_ && retire_requested_.load(std::memory_order_acquire)) {
        retiring_ = true;
        retire_until_ = engine_.end(leaving_, now);
    }
    if (retiring_ && now >= retire_until_) {
        retire_until_ = kNever;
        retired_.store(true, std::memory_order_release);
    }
    Loop* next = successor_.load(std::memory_order_acquire);
    if (next != nullptr) {
        next->take_over(*this, now);
    }
    return next;
}

void Loop::take_over(Loop& before, Instant now) {
    clock_ = now;
    read_until_ = now;
    absence_ = before.absence_;
    std::swap(changes_, before.changes_);
    engine_.tell_changes_to(*changes_);
    before.accept_given_links();
    read_second_sockets(before, now);
    // Changes up to here have the indices of the loop before.
    changes_before_ = changes_->newest();
    waits_.continue_from(before.waits_);
    take_ports(before, now);
    stations_.start(now);
    stations_.continue_from(before.stations_, carry_.engine, carry_.values, now);
    set_devices_present();
    if (settings_.lines != nullptr) {
        levels_ = settings_.lines->levels(now);
        engine_.set_lines(levels_, now);
    }
    for (std::size_t i = 0; i < input_timing_.size(); ++i) {
        if (const CarriedFrom from = carry_.engine.inputs[i].from) {
            std::swap(input_timing_[i], before.input_timing_[*from]);
        }
    }
    for (std::size_t i = 0; i < output_timing_.size(); ++i) {
        if (const CarriedFrom from = carry_.engine.outputs[i].from) {
            std::swap(output_timing_[i], before.output_timing_[*from]);
        }
    }
    took_over_ = true;
    publish(now);
}

/// For interfaces that both loops have open: the loop before gets the frames that came so far. A
/// frame that comes between the two calls is seen twice, which is better than not at all.
void Loop::read_second_sockets(Loop& before, Instant now) {
    for (std::size_t port = 0; port < ports_.size(); ++port) {
        const CarriedFrom from = carry_.ports[port].from;
        if (from && ports_[port].link) {
            discard_unread_of(*ports_[port].link, now);
            before.read_port(*from, now);
        }
    }
}

void Loop::take_ports(Loop& before, Instant now) {
    for (std::size_t port = 0; port < ports_.size(); ++port) {
        const PortCarry& carry = carry_.ports[port];
        if (carry.takes_link) {
            take_link(port, before.ports_[*carry.from], carry, now);
        }
    }
    // The main thread closes the links that are left. Their events must not be reported any more.
    for (Port& port : before.ports_) {
        if (port.link && port.watch) {
            waits_.end(*port.watch, *port.link);
        }
    }
    for (std::size_t port = 0; port < ports_.size(); ++port) {
        if (!carry_.ports[port].takes_link) {
            watch(port);
        }
    }
}

void Loop::take_link(std::size_t index, Port& before, const PortCarry& carry, Instant now) {
    Port& port = ports_[index];
    port.link = std::move(before.link);
    port.told_bus = before.told_bus;
    port.lost.store(before.lost.exchange(nullptr), std::memory_order_release);
    port.watch = std::exchange(before.watch, std::nullopt);
    if (port.watch) {
        waits_.set_port(*port.watch, index);
    }
    if (port.wiring.byte_time == before.wiring.byte_time) {
        port.pacer = before.pacer;
    }
    port.quiet_until = std::exchange(before.quiet_until, kNever);
    quiet_ports_ += port.quiet_until == kNever ? 0U : 1U;
    if (!port.link) {
        return;
    }
    if (carry.discards_unread) {
        discard_unread_of(*port.link, now);
    }
    if (port.link->as_bytes() != nullptr &&
        wants_bytes(port.wiring.stations) != wants_bytes(before.wiring.stations)) {
        set_watched(index, wants_bytes(port.wiring.stations));
    }
}

void Loop::discard_unread_of(Link& link, Instant now) {
    if (ByteLink* bytes = link.as_bytes()) {
        bytes->discard_unread();
        return;
    }
    can_reception_.full = true;
    for (int i = 0; i < kMostReads && can_reception_.full; ++i) {
        link.as_can()->read(can_reception_, now, wall_time_now());
    }
}

}  // namespace tribus
