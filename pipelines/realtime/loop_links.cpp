#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "pipelines/realtime/loop.h"

/// Moves links between the data thread, which uses them, and the main thread, which opens and
/// closes them.
namespace tribus {

void Loop::watch(std::size_t port) {
    Link* link = ports_[port].link.get();
    if (link == nullptr || link->descriptor() < 0) {
        return;
    }
    // Bytes that nobody reads would wake the thread for ever. A CAN socket also reports what became
    // of sent frames.
    const bool wanted = wants_bytes(ports_[port].wiring.stations) || link->as_can() != nullptr;
    ports_[port].watch = waits_.watch(*link, port, wanted);
    if (!ports_[port].watch) {
        lose(ports_[port]);
    }
}

void Loop::set_watched(std::size_t port, bool watched) {
    if (ports_[port].watch) {
        waits_.set_arrivals(*ports_[port].watch, *ports_[port].link, watched);
    }
}

/// Lets epoll report once more what a port still has: bytes that were not read, or a hang-up.
void Loop::watch_again(std::size_t index) {
    const Port& port = ports_[index];
    if (port.link && port.quiet_until == kNever && port.link->wakes_at_each_arrival() &&
        wants_bytes(port.wiring.stations)) {
        set_watched(index, true);
    }
}

void Loop::end_watch(Port& port) {
    if (port.link && port.watch) {
        waits_.end(*port.watch, *port.link);
    }
    port.watch.reset();
}

void Loop::lose(Port& port) {
    if (port.quiet_until != kNever) {
        port.quiet_until = kNever;
        --quiet_ports_;
    }
    end_watch(port);
    for (const Station& station : port.wiring.stations) {
        stations_.device_lost(station);
    }
    // Closing may take long in the kernel, so the main thread does it.
    port.lost.store(port.link.release(), std::memory_order_release);
}

std::unique_ptr<Link> Loop::take_lost(std::size_t port) {
    return std::unique_ptr<Link>(ports_[port].lost.exchange(nullptr, std::memory_order_acquire));
}

void Loop::give(std::size_t port, std::unique_ptr<Link> link) {
    delete ports_[port].given.exchange(link.release(), std::memory_order_acq_rel);
    set_event(waits_.wake_up());
}

void Loop::set_event(int event) {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(event, &one, sizeof one);
}

void Loop::accept_given_links() {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto taken = ::read(waits_.wake_up(), &count, sizeof count);
    for (std::size_t port = 0; port < ports_.size(); ++port) {
        Link* given = ports_[port].given.exchange(nullptr, std::memory_order_acquire);
        if (given != nullptr) {
            ports_[port].link.reset(given);
            set_device_present(ports_[port]);
            watch(port);
        }
    }
}

void Loop::set_device_present(const Port& port) {
    for (const Station& station : port.wiring.stations) {
        stations_.set_device_present(station, port.link != nullptr);
    }
}

void Loop::set_devices_present() {
    for (const Port& port : ports_) {
        set_device_present(port);
    }
}

}  // namespace tribus
