#include "pipelines/realtime/gpio_thread.h"

#include <sched.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <utility>

#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/scheduling.h"
#include "transports/links/start_thread.h"

namespace tribus {
namespace {

/// Period in which every line is read even without an edge, because the removal of a chip does not
/// wake a thread that already waits for its edges.
constexpr Duration kLookPeriod = std::chrono::milliseconds(200);
/// Longest age of an edge that matters: longer than any debouncing.
constexpr Duration kLongestAge = std::chrono::seconds(2);

}  // namespace

GpioThread::GpioThread(LineExchange& exchange, const std::vector<LineTask>& tasks,
                       std::vector<std::unique_ptr<HeldLine>> lines, GpioThreadSettings settings)
    : exchange_(exchange), settings_(settings) {
    const Instant now = monotonic_now();
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        lines_.emplace_back(tasks[i], now).held = std::move(lines[i]);
    }
    read_inputs(now, true);
}

GpioThread::~GpioThread() {
    end();
    for (const bool inverters : {false, true}) {
        for (Line& line : lines_) {
            if ((line.task.role == LineRole::inverter) == inverters) {
                line.held.reset();
                delete line.lost.exchange(nullptr);
                delete line.given.exchange(nullptr);
            }
        }
    }
}

tl::expected<void, std::string> GpioThread::start() {
    const int error = start_thread(thread_, kRealtimeStackBytes, &GpioThread::main, this);
    if (error != 0) {
        return tl::unexpected(std::string("cannot start the thread of the GPIO lines: ") +
                              std::strerror(error));
    }
    started_ = true;
    return {};
}

void GpioThread::end() {
    if (!started_) {
        return;
    }
    end_requested_.store(true, std::memory_order_release);
    exchange_.wake_lines();
    ::pthread_join(thread_, nullptr);
    started_ = false;
}

std::unique_ptr<HeldLine> GpioThread::take_lost(std::size_t line) {
    return std::unique_ptr<HeldLine>(
        lines_[line].lost.exchange(nullptr, std::memory_order_acquire));
}

void GpioThread::give(std::size_t line, std::unique_ptr<HeldLine> held) {
    delete lines_[line].given.exchange(held.release(), std::memory_order_acq_rel);
    exchange_.wake_lines();
}

void* GpioThread::main(void* self) {
    static_cast<GpioThread*>(self)->run();
    return nullptr;
}

void GpioThread::run() {
    ::pthread_setname_np(::pthread_self(), "tribus-gpio");
    if (settings_.priority) {
        // If the kernel refuses it, it refused it for the data thread too, which has reported that.
        const sched_param parameters{.sched_priority = *settings_.priority};
        ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters);
    }
    while (!end_requested_.load(std::memory_order_acquire)) {
        const Instant now = monotonic_now();
        const bool all = now >= next_look_;
        next_look_ = all ? now + kLookPeriod : next_look_;
        accept_given_lines();
        read_inputs(now, all);
        show_outputs(now, all);
        wait(next_deadline(now));
    }
    for (Line& line : lines_) {
        if (line.task.role == LineRole::link || line.task.role == LineRole::channel_switch) {
            set_line(line, false);
        }
    }
}

void GpioThread::wait(Instant until) {
    std::array<Line*, kMostLines> inputs{};
    std::size_t count = 0;
    const Instant now = monotonic_now();
    for (Line& line : lines_) {
        if (line.held && line.held->input && line.contact.rests_until() <= now) {
            polled_[count] = {.fd = line.held->input->descriptor(), .events = POLLIN, .revents = 0};
            inputs[count++] = &line;
        }
    }
    polled_[count] = {.fd = exchange_.lines_event(), .events = POLLIN, .revents = 0};
    const Duration pause = std::clamp(until - now, Duration::zero(), kLookPeriod);
    const timespec timeout = as_timespec(pause);
    if (::ppoll(polled_.data(), count + 1, &timeout, nullptr) <= 0) {
        return;
    }
    for (std::size_t i = 0; i < count; ++i) {
        inputs[i]->wants_look = polled_[i].revents != 0;
    }
    if (polled_[count].revents != 0) {
        exchange_.clear_lines_event();
    }
}

void GpioThread::accept_given_lines() {
    for (Line& line : lines_) {
        if (HeldLine* given = line.given.exchange(nullptr, std::memory_order_acquire)) {
            line.held.reset(given);
            line.last_set.reset();
            line.wants_look = true;
        }
    }
}

void GpioThread::read_inputs(Instant now, bool all) {
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        Line& line = lines_[i];
        if (is_input_role(line.task.role)) {
            if (line.held && (line.wants_look || all || line.contact.settles_at() <= now)) {
                read_input(line, now);
            }
            line.wants_look = false;
            levels_.set(i, line.contact.level());
        }
    }
    exchange_.set_levels(levels_, now);
}

void GpioThread::read_input(Line& line, Instant now) {
    kept_by_kernel_.store(true, std::memory_order_release);
    const std::optional<bool> level = line.held->input->read();
    kept_by_kernel_.store(false, std::memory_order_release);
    const std::optional<Duration> edge = line.held->input->latest_edge();
    std::optional<Instant> edge_at;
    if (edge) {
        edge_at = now - std::clamp(awake_time_now() - *edge, Duration::zero(), kLongestAge);
    } else if (line.wants_look) {
        edge_at = now;
    }
    line.contact.look(level, edge_at, now);
    if (!level) {
        lose(line);
    }
}

bool GpioThread::wanted(std::size_t index, Instant now) {
    Line& line = lines_[index];
    if (line.task.role == LineRole::fresh) {
        if (now >= line.wave.next()) {
            line.wave.turn(exchange_.fresh_at(line.task.outputs), now);
        }
        return line.wave.active();
    }
    const LineStates states = exchange_.states();
    return (states.on & line_bit(index)) != 0 ||
           ((states.blinking & line_bit(index)) != 0 && blink_is_on(now));
}

void GpioThread::show_outputs(Instant now, bool all) {
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        if (!is_input_role(lines_[i].task.role)) {
            const bool active = wanted(i, now);
            if (all || lines_[i].last_set != active) {
                set_line(lines_[i], active);
            }
        }
    }
}

void GpioThread::set_line(Line& line, bool active) {
    if (!line.held) {
        return;
    }
    line.last_set = active;
    kept_by_kernel_.store(true, std::memory_order_release);
    const bool is_set = line.held->output->set(active);
    kept_by_kernel_.store(false, std::memory_order_release);
    if (!is_set) {
        lose(line);
    }
}

void GpioThread::lose(Line& line) {
    // Closing may take long in the kernel, so the main thread does it.
    line.lost.store(line.held.release(), std::memory_order_release);
}

Instant GpioThread::next_deadline(Instant now) const {
    Instant next = next_look_;
    if (exchange_.states().blinking != 0) {
        next = std::min(next, next_blink(now));
    }
    for (const Line& line : lines_) {
        next = std::min(next, line.contact.settles_at());
        if (line.contact.rests_until() > now) {
            next = std::min(next, line.contact.rests_until());
        }
        if (line.task.role == LineRole::fresh) {
            next = std::min(next, line.wave.next());
        }
    }
    return next;
}

}  // namespace tribus
