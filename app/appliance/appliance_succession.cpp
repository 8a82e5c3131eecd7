#include <algorithm>
#include <cstddef>
#include <ctime>
#include <tuple>
#include <utility>

#include "app/appliance/appliance.h"
#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/locked_memory.h"

namespace tribus {
namespace {

std::size_t outputs_on(const PortPlan& plan) {
    return static_cast<std::size_t>(
        std::ranges::count(plan.wiring.stations, StationKind::output, &Station::kind));
}

}  // namespace

/// With many users the number of outputs must be equal: frames of a lane that are on their way then
/// stay so.
bool Appliance::same_use(const PortPlan& plan, const Appliance& before,
                         const PortPlan& plan_before) const {
    return (plan.config.medium->users != Users::many ||
            outputs_on(plan) == outputs_on(plan_before)) &&
           link_use(stations(), plan) == link_use(before.stations(), plan_before);
}

PortCarry Appliance::carry_port(const PortPlan& plan, const Appliance& before) const {
    const auto known = std::ranges::find_if(before.plans_, [&](const PortPlan& plan_before) {
        return same_device(plan_before.config, plan.config);
    });
    if (known == before.plans_.end()) {
        return {};
    }
    return {.from = static_cast<std::size_t>(known - before.plans_.begin()),
            .takes_link = same_use(plan, before, *known),
            .discards_unread = plan.config.medium->users != Users::many &&
                               wants_bytes(plan.wiring.stations) &&
                               !wants_bytes(known->wiring.stations)};
}

/// Only a place with many users can be open twice.
std::vector<std::string> Appliance::open_beside(const Appliance& before,
                                                std::vector<PortCarry>& ports,
                                                std::vector<std::unique_ptr<Link>>& links) {
    std::vector<std::string> errors;
    for (std::size_t port = 0; port < plans_.size(); ++port) {
        const PortCarry& carry = ports.emplace_back(carry_port(plans_[port], before));
        links.push_back(nullptr);
        if (carry.from && (carry.takes_link || before.missing_[*carry.from])) {
            missing_[port] = before.missing_[*carry.from];
            continue;
        }
        if (carry.from && plans_[port].config.medium->users != Users::many) {
            missing_[port] = true;
            continue;
        }
        auto link = open_port(configuration_, stations(), plans_[port]);
        if (link) {
            links.back() = std::move(*link);
        } else {
            errors.push_back(link.error());
        }
    }
    return errors;
}

/// Takes three of their periods; the other outputs go on meanwhile.
void Appliance::retire_parts(const Leaving& leaving) {
    if (leaving.empty()) {
        return;
    }
    loop_->retire(leaving);
    while (!loop_->retired() && !thread_->failed()) {
        const timespec pause{.tv_sec = 0, .tv_nsec = 1'000'000};
        ::nanosleep(&pause, nullptr);
    }
}

tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> Appliance::succeed(
    std::unique_ptr<Appliance>& running, std::unique_ptr<Appliance> next,
    const CarryOver& carry_over, std::unique_ptr<FlightRecorder>& left_over) {
    std::unique_ptr<FlightRecorder>& recorder = running->recorder_ ? running->recorder_ : left_over;
    if (auto made = next->make_recorder(recorder, DiskPatience::does_not_wait); !made) {
        return tl::unexpected(std::vector{made.error()});
    }
    next->open_files();
    if (!next->file_errors_.empty()) {
        return tl::unexpected(next->file_errors_);
    }
    LoopCarry carry{.engine = carry_over.engine, .values = carry_over.values, .ports = {}};
    std::vector<std::unique_ptr<Link>> links;
    std::vector<std::string> errors = next->open_beside(*running, carry.ports, links);
    if (!errors.empty()) {
        return tl::unexpected(std::move(errors));
    }
    std::vector<PortWiring> wiring;
    for (const PortPlan& plan : next->plans_) {
        wiring.push_back(plan.wiring);
    }
    next->loop_ = std::make_unique<Loop>(*next->engine_, std::move(wiring), std::move(links),
                                         next->loop_settings(running->line_exchange_.get()));
    if (auto prepared = next->loop_->prepare(); !prepared) {
        return tl::unexpected(std::vector{prepared.error()});
    }
    // Memory that cannot be locked was already reported at the start.
    if (next->configuration_.runtime.realtime != Realtime::off) {
        std::ignore = lock_new_memory();
    }
    next->look_at_machine(monotonic_now());
    running->retire_parts(carry_over.leaving);
    next->loop_->discard_unread();
    running->thread_->hand_over_to(*next->loop_, std::move(carry));
    next->thread_ = std::move(running->thread_);
    next->line_exchange_ = std::move(running->line_exchange_);
    next->gpio_thread_ = std::move(running->gpio_thread_);
    next->missing_lines_ = running->missing_lines_;
    next->silent_looks_ = running->silent_looks_;
    next->missing_realtime_ = running->missing_realtime_;
    next->record_ports(recorder.get());
    if (next->configuration_.recorder) {
        next->recorder_ = std::move(recorder);
    } else if (running->recorder_) {
        left_over = std::move(running->recorder_);
    }
    // Closes the devices that `next` did not take; `reopen_devices` can then open them.
    running.reset();
    return next;
}

}  // namespace tribus
