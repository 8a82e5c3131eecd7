#include <algorithm>
#include <chrono>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "app/appliance/appliance.h"
#include "config/load.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

Appliance::DeviceEvent event_of(const PortConfig& config, bool back) {
    return {.kind = config.medium->place.key, .name = config.device, .back = back};
}

Appliance::DeviceEvent event_of(const LineConfig& config, bool back) {
    return {.kind = "line", .name = config.name + " (" + to_text(config.place) + ")", .back = back};
}

}  // namespace

std::vector<Appliance::DeviceEvent> Appliance::devices() const {
    std::vector<DeviceEvent> all;
    for (std::size_t port = 0; port < plans_.size(); ++port) {
        all.push_back(event_of(plans_[port].config, port_present(port)));
    }
    for (std::size_t line = 0; line < missing_lines_.size(); ++line) {
        all.push_back(event_of(configuration_.lines[line], line_present(line)));
    }
    return all;
}

std::vector<Appliance::DeviceEvent> Appliance::reopen_devices() {
    std::vector<DeviceEvent> events;
    for (std::size_t port = 0; port < plans_.size(); ++port) {
        if (loop_->take_lost(port)) {
            missing_[port] = true;
            events.push_back(event_of(plans_[port].config, false));
        }
        if (missing_[port] && monotonic_now() >= open_problems_[port].try_at) {
            constexpr Duration kLong = std::chrono::milliseconds(50);
            constexpr int kPause = 10;
            const Instant begin = monotonic_now();
            auto link = open_port(configuration_, stations(), plans_[port]);
            if (!link) {
                const Duration took = monotonic_now() - begin;
                tell_problem(port, link.error(), events);
                open_problems_[port].try_at = took < kLong ? Instant{} : begin + kPause * took;
                continue;
            }
            loop_->give(port, std::move(*link));
            missing_[port] = false;
            open_problems_[port] = {};
            events.push_back(event_of(plans_[port].config, true));
        }
    }
    reopen_lines(events);
    return events;
}

Appliance::DeviceNews Appliance::look_after_devices(Instant now) {
    DeviceNews news{reopen_devices()};
    for (std::size_t port = 0; port < plans_.size(); ++port) {
        if (plans_[port].config.medium->shape == WireShape::can_frames) {
            const bool off = can_status(port).state == CanBusState::bus_off;
            if (auto restart = bus_off_watch_.look(plans_[port].config.device, off, now)) {
                news.restarts.push_back(std::move(*restart));
            }
        }
    }
    return news;
}

/// A device that is missing is told elsewhere. One that was just unplugged or plugged in may be
/// there without being one for a moment.
void Appliance::tell_problem(std::size_t port, const std::string& problem,
                             std::vector<DeviceEvent>& events) {
    const PortConfig& config = plans_[port].config;
    OpenProblem& before = open_problems_[port];
    if (config.medium->is_missing(config.device)) {
        before = {};
    } else if (before.text != problem) {
        before = {problem};
    } else if (!std::exchange(before.told, true)) {
        events.push_back(event_of(config, false));
        events.back().problem = problem;
    }
}

bool Appliance::line_present(std::size_t line) const {
    return !missing_lines_[line] &&
           !(lines_hang() && is_input_role(configuration_.lines[line].task.role));
}

void Appliance::look_whether_lines_hang(std::vector<DeviceEvent>& events) {
    const bool silent = line_exchange_ != nullptr && line_exchange_->hangs(monotonic_now());
    const bool before = lines_hang();
    silent_looks_ = silent ? std::min(silent_looks_ + 1, kSilentLooks) : 0;
    if (lines_hang() == before) {
        return;
    }
    for (std::size_t line = 0; line < missing_lines_.size(); ++line) {
        const LineConfig& config = configuration_.lines[line];
        if (is_input_role(config.task.role) && !missing_lines_[line]) {
            events.push_back(event_of(config, before));
        }
    }
}

void Appliance::reopen_lines(std::vector<DeviceEvent>& events) {
    look_whether_lines_hang(events);
    // Finding a line queries all lines of all chips; about once a second is enough.
    constexpr int kCallsPerOpening = 5;
    calls_until_opening_ = calls_until_opening_ == 0 ? kCallsPerOpening : calls_until_opening_ - 1;
    for (std::size_t i = 0; i < missing_lines_.size(); ++i) {
        const LineConfig& config = configuration_.lines[i];
        if (gpio_thread_->take_lost(i)) {
            missing_lines_[i] = true;
            events.push_back(event_of(config, false));
        }
        if (missing_lines_[i] && calls_until_opening_ == 0) {
            if (auto line = open_line(configuration_, config)) {
                gpio_thread_->give(i, std::move(*line));
                missing_lines_[i] = false;
                events.push_back(event_of(config, true));
            }
        }
    }
}

}  // namespace tribus
