#include "pipelines/realtime/loop.h"

#include <pthread.h>
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

/// Stands for the wake-up descriptor among the port numbers of epoll events.
constexpr std::uint64_t kWakeUp = ~std::uint64_t{0};
/// How often the main thread gets fresh figures: twice as often as it looks at them.
constexpr Duration kPublishPeriod = std::chrono::milliseconds(100);
/// The longest sleep without a deadline, so that figures do not stand still.
constexpr Duration kLongestWait = std::chrono::milliseconds(250);

std::string error_text(const char* what) {
    return std::string(what) + " failed: " + std::strerror(errno);
}

bool is_can(const Engine& engine, const PortWiring& wiring) {
    return std::ranges::any_of(wiring.inputs,
                               [&](std::size_t i) { return engine.inputs()[i].on_can(); }) ||
           std::ranges::any_of(wiring.outputs,
                               [&](std::size_t i) { return engine.outputs()[i].on_can(); });
}

}  // namespace

Loop::Loop(Engine& engine, std::vector<PortWiring> wiring, std::vector<std::unique_ptr<Link>> links,
           LoopSettings settings)
    : engine_(engine),
      settings_(settings),
      routes_(engine.outputs().size()),
      input_status_(engine.inputs().size()),
      output_status_(engine.outputs().size()),
      input_timing_(engine.inputs().size()),
      output_timing_(engine.outputs().size()) {
    for (std::size_t i = 0; i < wiring.size(); ++i) {
        Port& port = ports_.emplace_back();
        port.wiring = wiring[i];
        port.link = std::move(links[i]);
        port.pacer = ReadPacer(wiring[i].byte_time);
        for (std::size_t lane = 0; lane < wiring[i].outputs.size(); ++lane) {
            routes_[wiring[i].outputs[lane]] = {.port = i, .lane = lane};
        }
        if (is_can(engine, wiring[i])) {
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
    epoll_ = UniqueFd(::epoll_create1(EPOLL_CLOEXEC));
    if (epoll_.get() < 0) {
        return tl::unexpected(error_text("epoll_create1"));
    }
    has_epoll_pwait2_ = has_epoll_pwait2(epoll_.get());
    wake_up_ = UniqueFd(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    if (wake_up_.get() < 0) {
        return tl::unexpected(error_text("eventfd"));
    }
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.u64 = kWakeUp;
    if (::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, wake_up_.get(), &event) != 0) {
        return tl::unexpected(error_text("epoll_ctl"));
    }
    for (std::size_t port = 0; port < ports_.size(); ++port) {
        watch(port);
    }
    return {};
}

void Loop::watch(std::size_t port) {
    Link* link = ports_[port].link.get();
    if (link == nullptr || link->descriptor() < 0) {
        return;
    }
    epoll_event event{};
    // A hang-up is reported without being asked for; bytes that nobody wants would wake for ever.
    // A CAN socket also tells what became of frames that were sent.
    const bool wanted = !ports_[port].wiring.inputs.empty() || link->as_can() != nullptr;
    event.events = wanted ? EPOLLIN : 0U;
    event.data.u64 = port;
    if (::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, link->descriptor(), &event) != 0) {
        lose(ports_[port]);
    }
}

void Loop::set_watched(std::size_t port, bool watched) {
    epoll_event event{};
    event.events = watched ? EPOLLIN : 0U;
    event.data.u64 = port;
    ::epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, ports_[port].link->descriptor(), &event);
}

void Loop::lose(Port& port) {
    if (port.quiet_until != kNever) {
        port.quiet_until = kNever;
        --quiet_ports_;
    }
    ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, port.link->descriptor(), nullptr);
    for (const std::size_t input : port.wiring.inputs) {
        engine_.device_lost(input);
    }
    // Closing may take the kernel long: the main thread does it.
    port.lost.store(port.link.release(), std::memory_order_release);
}

std::unique_ptr<Link> Loop::take_lost(std::size_t port) {
    return std::unique_ptr<Link>(ports_[port].lost.exchange(nullptr, std::memory_order_acquire));
}

void Loop::give(std::size_t port, std::unique_ptr<Link> link) {
    delete ports_[port].given.exchange(link.release(), std::memory_order_acq_rel);
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(wake_up_.get(), &one, sizeof one);
}

void Loop::request_end() {
    end_requested_.store(true, std::memory_order_release);
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(wake_up_.get(), &one, sizeof one);
}

void Loop::accept_given_links() {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto taken = ::read(wake_up_.get(), &count, sizeof count);
    for (std::size_t port = 0; port < ports_.size(); ++port) {
        Link* given = ports_[port].given.exchange(nullptr, std::memory_order_acquire);
        if (given != nullptr) {
            ports_[port].link.reset(given);
            watch(port);
        }
    }
}

ReadStatus Loop::read_bytes(std::size_t port, ByteLink& link, Instant now) {
    const ReadStatus status = link.read(reception_);
    if (status != ReadStatus::received) {
        return status;
    }
    bool frame_came = false;
    const bool clean = reception_.damaged.none();
    for (const std::size_t input : ports_[port].wiring.inputs) {
        if (clean ? engine_.receive(input, reception_.view(), now)
                  : engine_.receive(input, reception_.view(), reception_.damaged, now)) {
            input_timing_[input].frame_came(now);
            frame_came = true;
        }
    }
    const Instant read_next = ports_[port].pacer.delivered(reception_.count, frame_came, now);
    if (read_next > now) {
        set_watched(port, false);
        ports_[port].quiet_until = read_next;
        ++quiet_ports_;
    }
    return status;
}

ReadStatus Loop::read_can(const PortWiring& wiring, CanLink& link, Instant now) {
    const ReadStatus status = link.read(can_reception_, now, wall_time_now());
    if (status == ReadStatus::received) {
        for (const ReceivedCanFrame& received : can_reception_.view()) {
            for (const std::size_t input : wiring.inputs) {
                if (engine_.receive(input, received.frame, received.at)) {
                    input_timing_[input].frame_came(received.at);
                }
            }
            for (const std::size_t output : wiring.outputs) {
                engine_.watch_for_foreign_sender(output, received.frame, received.at);
            }
        }
    }
    return status;
}

void Loop::read_port(std::size_t index, Instant now) {
    Port& port = ports_[index];
    if (!port.link) {
        return;
    }
    if (port.quiet_until != kNever) {
        port.quiet_until = kNever;
        --quiet_ports_;
        set_watched(index, true);
    }
    ByteLink* bytes = port.link->as_bytes();
    const ReadStatus status = bytes != nullptr ? read_bytes(index, *bytes, now)
                                               : read_can(port.wiring, *port.link->as_can(), now);
    if (status == ReadStatus::lost) {
        lose(port);
    }
}

void Loop::read_quiet_ports(Instant now) {
    for (std::size_t port = 0; quiet_ports_ > 0 && port < ports_.size(); ++port) {
        if (ports_[port].quiet_until <= now) {
            read_port(port, now);
        }
    }
}

namespace {

WriteStatus hand_over(Link& link, std::size_t lane, const Transmission& sent, Instant now) {
    ByteLink* bytes = link.as_bytes();
    return bytes != nullptr ? bytes->write(sent.bytes)
                            : link.as_can()->write(lane, sent.can_frames, now);
}

void count(WriteStatus status, Output& output) {
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

}  // namespace

void Loop::write_outputs(Instant now) {
    for (const std::size_t index : engine_.ran()) {
        Output& output = engine_.output(index);
        const Transmission sent = output.take();
        if (sent.empty()) {
            continue;
        }
        const auto [port_index, lane] = routes_[index];
        Port& port = ports_[port_index];
        const WriteStatus status =
            port.link ? hand_over(*port.link, lane, sent, now) : WriteStatus::lost;
        clock_ = monotonic_now();
        count(status, output);
        if (status == WriteStatus::written) {
            output_timing_[index].frame_went({.due = output.latest_due(),
                                              .taken = now,
                                              .handed_over = clock_,
                                              .read = output.latest().received,
                                              .period = output.period()});
        } else if (status == WriteStatus::lost && port.link) {
            lose(port);
        }
    }
}

Instant Loop::poll_can_links(Instant now) {
    Instant next = kNever;
    for (const std::size_t port : can_ports_) {
        if (ports_[port].link) {
            next = std::min(next, ports_[port].link->as_can()->poll(now));
        }
    }
    return next;
}

/// Runs and sends what is due; returns when something will be.
Instant Loop::advance(Instant now) {
    Instant next = engine_.poll(now);
    write_outputs(now);
    next = std::min(next, poll_can_links(now));
    for (std::size_t port = 0, left = quiet_ports_; left > 0; ++port) {
        if (ports_[port].quiet_until != kNever) {
            next = std::min(next, ports_[port].quiet_until);
            --left;
        }
    }
    return next;
}

void Loop::publish(Instant now) {
    if (now < next_publish_) {
        return;
    }
    next_publish_ = now + kPublishPeriod;
    for (std::size_t i = 0; i < input_status_.size(); ++i) {
        const Input& input = engine_.inputs()[i];
        InputStatus status;
        status.latest = input.latest();
        status.counts = input.counts();
        for (const NamedCount& cause : input.decoder().rejected()) {
            status.rejected += cause.count;
        }
        status.skipped_bytes = input.decoder().skipped_bytes();
        status.interval = input.arrivals().interval();
        status.alive = input.alive(now);
        status.ever_good = input.ever_good();
        input_status_[i].publish(status);
    }
    for (std::size_t i = 0; i < output_status_.size(); ++i) {
        const Output& output = engine_.outputs()[i];
        OutputStatus status;
        status.latest = output.latest();
        status.counts = output.counts();
        status.overruns = output.overruns();
        status.stage = output.stage();
        output_status_[i].publish(status);
    }
    for (const std::size_t port : can_ports_) {
        if (ports_[port].link) {
            ports_[port].can_status.publish(ports_[port].link->as_can()->status());
        }
    }
}

std::size_t Loop::wait(Instant until) {
    const std::size_t ready = wait_until(until - std::min(settings_.spin, until - clock_));
    clock_ = monotonic_now();
    while (ready == 0 && clock_ < until && until - clock_ <= settings_.spin) {
        clock_ = monotonic_now();
    }
    return ready;
}

std::size_t Loop::wait_until(Instant until) {
    // What was counted and published since the last write must not be slept on top.
    const Duration sleep = std::clamp(until - monotonic_now(), Duration::zero(), kLongestWait);
    const auto seconds = std::chrono::floor<std::chrono::seconds>(sleep);
    timespec timeout{};
    timeout.tv_sec = seconds.count();
    timeout.tv_nsec = (sleep - seconds).count();
    std::array<epoll_event, kEventsPerWake> events;
    const int count = wait_for_events(epoll_.get(), events, timeout, has_epoll_pwait2_);
    std::size_t ready = 0;
    for (int i = 0; i < count; ++i) {
        const std::uint64_t source = events[static_cast<std::size_t>(i)].data.u64;
        if (source == kWakeUp) {
            accept_given_links();
        } else {
            ready_[ready++] = static_cast<std::size_t>(source);
        }
    }
    return ready;
}

void Loop::run() {
    // From here on this thread allocates nothing; the tests recognise it by its name.
    ::pthread_setname_np(::pthread_self(), "tribus-data");
    clock_ = monotonic_now();
    engine_.start(clock_);
    std::optional<Instant> end_at;
    Instant next = advance(clock_);
    Instant now = clock_;
    while (!end_at || now < *end_at) {
        const std::size_t ready = wait(std::min(next, end_at.value_or(kNever)));
        now = clock_;
        if (!end_at && end_requested_.load(std::memory_order_acquire)) {
            end_at = engine_.end(now);
        }
        for (std::size_t i = 0; i < ready; ++i) {
            read_port(ready_[i], now);
        }
        read_quiet_ports(now);
        if (!end_at || now < *end_at) {
            next = advance(now);
        }
        publish(now);
    }
    next_publish_ = now;
    publish(now);
}

}  // namespace tribus
