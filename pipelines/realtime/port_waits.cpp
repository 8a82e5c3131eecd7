#include "pipelines/realtime/port_waits.h"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/exact_wait.h"

namespace tribus {
namespace {

/// Events of other threads have this number; no watch has such a place.
constexpr std::uint64_t kEvent = ~std::uint64_t{0};

std::string error_text(const char* what) {
    return std::string(what) + " failed: " + std::strerror(errno);
}

std::uint64_t number_of(const PortWaits::Watch& watch) {
    return std::uint64_t{watch.generation} << 32U | watch.place;
}

std::uint32_t events_of(const Link& link, bool arrivals) {
    // The kernel reports a hang-up without EPOLLIN.
    if (!arrivals) {
        return 0;
    }
    return link.wakes_at_each_arrival() ? EPOLLIN | EPOLLET : EPOLLIN;
}

}  // namespace

tl::expected<void, std::string> PortWaits::prepare(std::size_t ports) {
    ports_ = ports;
    places_.resize(ports);
    epoll_ = UniqueFd(::epoll_create1(EPOLL_CLOEXEC));
    if (epoll_.get() < 0) {
        return tl::unexpected(error_text("epoll_create1"));
    }
    has_epoll_pwait2_ = has_epoll_pwait2(epoll_.get());
    wake_up_ = UniqueFd(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    if (wake_up_.get() < 0) {
        return tl::unexpected(error_text("eventfd"));
    }
    return add_event(wake_up_.get());
}

tl::expected<void, std::string> PortWaits::add_event(int descriptor) {
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.u64 = kEvent;
    if (::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, descriptor, &event) != 0) {
        return tl::unexpected(error_text("epoll_ctl"));
    }
    return {};
}

void PortWaits::make_room(const PortWaits& before) {
    places_.assign(std::max(before.places_.size(), before.ports_ + ports_), Place{});
}

void PortWaits::continue_from(PortWaits& before) {
    std::swap(epoll_, before.epoll_);
    std::swap(wake_up_, before.wake_up_);
    has_epoll_pwait2_ = before.has_epoll_pwait2_;
    std::ranges::copy(before.places_, places_.begin());
}

bool PortWaits::control(int operation, int descriptor, const Watch& watch,
                        std::uint32_t events) const {
    epoll_event event{};
    event.events = events;
    event.data.u64 = number_of(watch);
    return ::epoll_ctl(epoll_.get(), operation, descriptor, &event) == 0;
}

std::optional<PortWaits::Watch> PortWaits::watch(const Link& link, std::size_t port,
                                                 bool arrivals) {
    const auto free = std::ranges::find(places_, kNoPort, &Place::port);
    if (free == places_.end()) {
        return std::nullopt;
    }
    free->port = static_cast<std::uint32_t>(port);
    const Watch watch{.place = static_cast<std::uint32_t>(free - places_.begin()),
                      .generation = free->generation};
    const std::uint32_t events = events_of(link, arrivals);
    const auto add = [&](int descriptor) {
        return descriptor < 0 || control(EPOLL_CTL_ADD, descriptor, watch, events);
    };
    if (add(link.descriptor()) && add(link.second_descriptor())) {
        return watch;
    }
    end(watch, link);
    return std::nullopt;
}

void PortWaits::set_arrivals(const Watch& watch, const Link& link, bool arrivals) {
    control(EPOLL_CTL_MOD, link.descriptor(), watch, events_of(link, arrivals));
}

void PortWaits::set_port(const Watch& watch, std::size_t port) {
    places_[watch.place].port = static_cast<std::uint32_t>(port);
}

void PortWaits::end(const Watch& watch, const Link& link) {
    for (const int descriptor : {link.descriptor(), link.second_descriptor()}) {
        control(EPOLL_CTL_DEL, descriptor, watch, 0);
    }
    places_[watch.place] = {.generation = watch.generation + 1};
}

/// A filter of system calls may be put on a running program, so epoll_pwait2 can begin to fail.
int PortWaits::wait_for(const Duration& longest, std::span<epoll_event> events) {
    const timespec timeout = as_timespec(longest);
    int count = wait_for_events(epoll_.get(), events, timeout, has_epoll_pwait2_);
    if (count < 0 && errno != EINTR && has_epoll_pwait2_) {
        has_epoll_pwait2_ = false;
        count = wait_for_events(epoll_.get(), events, timeout, false);
    }
    return count;
}

/// After a wait that was interrupted or refused. Returns the number of events that wait.
int PortWaits::wait_again(std::span<epoll_event> events) {
    int count = -1;
    if (errno == EINTR) {
        news_ |= kInterrupted;
        count = wait_for(Duration::zero(), events);
    }
    if (count < 0 && errno != EINTR) {
        news_ |= kFailed;
        failure_ = errno;
    }
    return std::max(count, 0);
}

std::size_t PortWaits::wait(Duration longest, std::span<std::uint32_t, kMostReady> ready) {
    std::array<epoll_event, kMostReady> events;
    news_ = 0;
    int count = wait_for(longest, events);
    if (count < 0) {
        count = wait_again(events);
    }
    std::size_t found = 0;
    std::uint32_t kinds = EPOLLIN;
    const epoll_event* const end = events.data() + count;
    for (const epoll_event* event = events.data(); event != end; ++event) {
        const auto index = static_cast<std::uint32_t>(event->data.u64);
        if (index >= places_.size()) {
            news_ |= kEventCame;
        } else if (places_[index].generation == event->data.u64 >> 32U) {
            ready[found++] = places_[index].port;
            kinds |= event->events;
        }
    }
    if (kinds != EPOLLIN) {
        news_ |= kHungUp;
    }
    return found;
}

}  // namespace tribus
