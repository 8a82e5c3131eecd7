#include "pipelines/realtime/loop.h"

#include <pthread.h>

#include <algorithm>
#include <array>
#include <utility>

#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

/// Longest sleep without a deadline, so that published figures stay current.
constexpr Duration kLongestWait = std::chrono::milliseconds(250);
/// Above this lateness of a wake-up, waiting bytes may be old. Less than any period of frames, more
/// than a busy machine usually delays a thread.
constexpr Duration kMostLateness = std::chrono::milliseconds(5);

/// How long the end waits for one wake-up that is late.
constexpr Duration kMostWaitAtEnd = std::chrono::milliseconds(200);
/// Longest time from the request to end to the end. A service manager waits for it.
constexpr Duration kLongestEnd = std::chrono::seconds(1);

}  // namespace

Loop::Loop(Engine& engine, std::vector<PortWiring> wiring, std::vector<std::unique_ptr<Link>> links,
           LoopSettings settings)
    : engine_(engine),
      settings_(settings),
      stations_(engine, settings.values),
      ports_(wiring.size()),
      newest_at_ns_(engine.inputs().size()),
      input_figures_(engine.inputs().size()),
      frame_faults_(engine.inputs().size()),
      output_figures_(engine.outputs().size()),
      output_waits_(engine.outputs().size()),
      bus_states_(settings.values == nullptr ? 0 : settings.values->bus_count()),
      value_status_(settings.values == nullptr ? 0 : settings.values->board().size()),
      node_reports_(engine.node_count()) {
    engine_.tell_changes_to(*changes_);
    for (std::size_t i = 0; i < engine.inputs().size(); ++i) {
        input_timing_.push_back(std::make_unique<InputTiming>());
    }
    for (std::size_t i = 0; i < engine.outputs().size(); ++i) {
        output_timing_.push_back(std::make_unique<OutputTiming>());
    }
    for (std::size_t i = 0; i < wiring.size(); ++i) {
        Port& port = ports_[i];
        port.wiring = wiring[i];
        port.link = std::move(links[i]);
        port.pacer = ReadPacer(wiring[i].byte_time);
        std::size_t lane = 0;
        for (const Station& station : wiring[i].stations) {
            auto& routes = routes_[static_cast<std::size_t>(station.kind)];
            routes.resize(std::max(routes.size(), station.index + 1));
            routes[station.index] = {.port = i, .lane = sends(station) ? lane++ : 0};
        }
        if (std::ranges::any_of(port.wiring.stations,
                                [this](Station station) { return stations_.on_can(station); })) {
            can_ports_.push_back(i);
        }
    }
}

Loop::~Loop() {
    for (Port& port : ports_) {
        delete port.lost.load();
        delete port.given.load();
    }
}

tl::expected<void, std::string> Loop::prepare() {
    if (auto prepared = waits_.prepare(ports_.size()); !prepared) {
        return prepared;
    }
    if (settings_.lines != nullptr) {
        if (auto added = waits_.add_event(settings_.lines->data_event()); !added) {
            return added;
        }
    }
    for (std::size_t port = 0; port < ports_.size(); ++port) {
        watch(port);
    }
    return {};
}

void Loop::request_end() {
    end_requested_.store(true, std::memory_order_release);
    set_event(waits_.wake_up());
}

Instant Loop::poll_can_links(Instant now) {
    Instant next = kNever;
    for (const std::size_t port : can_ports_) {
        if (ports_[port].link) {
            next = std::min(next, ports_[port].link->as_can()->poll(now));
            tell_bus(port, now);
        }
    }
    return next;
}

void Loop::tell_bus(std::size_t port, Instant now) {
    const CanBusState state = ports_[port].link->as_can()->state();
    if (state != ports_[port].told_bus) {
        const PartState was{.bus = std::exchange(ports_[port].told_bus, state)};
        changes_->add({.at = now,
                       .part = Change::Part::bus,
                       .index = port,
                       .was = was,
                       .now = {.bus = state}});
    }
}

/// Runs and sends what is due. Returns when something will be due next.
Instant Loop::advance(Instant now) {
    Instant next = stations_.poll(now);
    send_ready(now);
    if (settings_.lines != nullptr && !engine_.ran().empty()) {
        settings_.lines->set_states(engine_.shown_on_lines());
    }
    if (!can_ports_.empty()) {
        next = std::min(next, poll_can_links(now));
    }
    if (settings_.values != nullptr) {
        next = std::min(next, stations_.poll_values(now));
        send_ready(now);
    }
    for (std::size_t port = 0, left = quiet_ports_; left > 0; ++port) {
        if (ports_[port].quiet_until != kNever) {
            next = std::min(next, ports_[port].quiet_until);
            --left;
        }
    }
    return next;
}

std::size_t Loop::wait(Instant until) {
    const Instant at_the_latest = std::min(until, later(clock_, kLongestWait));
    const std::size_t ready = wait_until(until - std::min(settings_.spin, until - clock_));
    clock_ = monotonic_now();
    const Instant in_time = waits_.interrupted() ? read_until_ : at_the_latest;
    late_by_ = clock_ - in_time;
    while (ready == 0 && clock_ < until && until - clock_ <= settings_.spin) {
        clock_ = monotonic_now();
    }
    return ready;
}

std::size_t Loop::wait_until(Instant until) {
    // The time spent since the last write must not delay the wake-up.
    const Duration sleep = std::clamp(until - monotonic_now(), Duration::zero(), kLongestWait);
    const std::size_t ready = waits_.wait(sleep, ready_);
    if (waits_.has_news()) {
        take_news(std::span(ready_).first(ready));
    }
    return ready;
}

/// Handles what a wait told besides bytes and frames.
void Loop::take_news(std::span<const std::uint32_t> ready) {
    if (waits_.failed()) {
        wait_failure_.store(waits_.failure(), std::memory_order_release);
    }
    for (std::size_t i = 0; waits_.hung_up() && i < ready.size(); ++i) {
        watch_again(ready[i]);
    }
    if (waits_.event_came()) {
        event_came_ = true;
        accept_given_links();
        if (settings_.lines != nullptr) {
            settings_.lines->clear_data_event();
        }
    }
}

void Loop::look_at_lines(Instant now) {
    if (settings_.lines == nullptr) {
        return;
    }
    const LineLevels levels = settings_.lines->levels(now);
    if (levels != levels_) {
        levels_ = levels;
        engine_.set_lines(levels, now);
    }
}

void Loop::begin() {
    // From here on this thread does not allocate. The tests recognise it by its name.
    ::pthread_setname_np(::pthread_self(), "tribus-data");
    clock_ = monotonic_now();
    read_until_ = clock_;
    stations_.start(clock_);
    set_devices_present();
    look_at_lines(clock_);
}

/// The thread cannot wait any more.
void Loop::end_at_once(Instant now) {
    engine_.end(now);
    advance(now);
    publish(now);
}

[[gnu::flatten]] Loop* Loop::run() {
    if (!took_over_) {
        begin();
    }
    std::optional<Instant> end_at;
    Instant latest_end = kNever;
    Instant next = advance(clock_);
    Instant now = clock_;
    while (!end_at || now < *end_at) {
        const std::size_t ready = wait(std::min({next, end_at.value_or(kNever), retire_until_}));
        now = clock_;
        if (failure() != 0) {
            end_at_once(now);
            return nullptr;
        }
        if (end_at) {
            // The last frames are sent though the thread could not run meanwhile.
            end_at = std::min(
                later(*end_at, std::clamp(late_by_, Duration::zero(), kMostWaitAtEnd)), latest_end);
        }
        // Requests of other threads come with an event. One that comes just when a loop takes over
        // from another may lack it, so they are looked for with each publication too.
        const bool asked = std::exchange(event_came_, false) || retiring_ || now >= next_publish_;
        if (asked && !end_at && end_requested_.load(std::memory_order_acquire)) {
            latest_end = later(now, kLongestEnd);
            end_at = std::min(engine_.end(now), latest_end);
        }
        look_at_lines(now);
        if (late_by_ > kMostLateness) {
            catch_up(read_until_, now);
        } else {
            for (std::size_t i = 0; i < ready; ++i) {
                read_port(ready_[i], now);
            }
            if (quiet_ports_ > 0) {
                read_quiet_ports(now);
            }
        }
        read_until_ = now;
        if (Loop* following = asked ? successor(now) : nullptr) {
            return following;
        }
        if (!end_at || now < *end_at) {
            next = advance(now);
        }
        if (can_answers_wait_) {
            answer_can_frames(now);
        }
        if (now >= next_publish_) {
            look_at_silent_ports(now);
            publish(now);
        }
    }
    publish(now);
    return nullptr;
}

}  // namespace tribus
