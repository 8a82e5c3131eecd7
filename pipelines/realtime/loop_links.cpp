#include <sys/epoll.h>
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
namespace {

std::uint32_t arrivals(const Link& link) {
    return link.wakes_at_each_arrival() ? EPOLLIN | EPOLLET : EPOLLIN;
}

}  // namespace

void Loop::watch(std::size_t port) {
    Link* link = ports_[port].link.get();
    if (link == nullptr || link->descriptor() < 0) {
        return;
    }
    epoll_event event{};
    // The kernel reports a hang-up without EPOLLIN. Bytes that nobody reads would wake the thread
    // for ever. A CAN socket also reports what became of sent frames.
    const bool wanted = wants_bytes(ports_[port].wiring.stations) || link->as_can() != nullptr;
    event.events = wanted ? arrivals(*link) : 0U;
    event.data.ptr = ports_[port].place.get();
    const auto add = [&](int descriptor) {
        return descriptor < 0 || ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, descriptor, &event) == 0;
    };
    if (!add(link->descriptor()) || !add(link->second_descriptor())) {
        lose(ports_[port]);
    }
}

void Loop::set_watched(std::size_t port, bool watched) {
    const Link& link = *ports_[port].link;
    epoll_event event{};
    event.events = watched ? arrivals(link) : 0U;
    event.data.ptr = ports_[port].place.get();
    ::epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, link.descriptor(), &event);
}

/// Lets epoll report once more what a port still has: bytes that were not read, or a hang-up.
[[gnu::noinline]] void Loop::watch_again(const Port& port) {
    if (port.link && port.quiet_until == kNever && port.link->wakes_at_each_arrival() &&
        wants_bytes(port.wiring.stations)) {
        set_watched(*port.place, true);
    }
}

[[gnu::noinline]] void Loop::lose(Port& port) {
    if (port.quiet_until != kNever) {
        port.quiet_until = kNever;
        --quiet_ports_;
    }
    for (const int descriptor : {port.link->descriptor(), port.link->second_descriptor()}) {
        ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, descriptor, nullptr);
    }
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
    set_event(wake_up_.get());
}

void Loop::set_event(int event) {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(event, &one, sizeof one);
}

[[gnu::noinline]] void Loop::accept_given_links() {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto taken = ::read(wake_up_.get(), &count, sizeof count);
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
