#include "app/log/can_report.h"

#include <algorithm>
#include <utility>

#include "app/journal/log.h"
#include "app/journal/log_fields.h"
#include "app/journal/log_limit.h"
#include "core/counted.h"
#include "transports/links/can/can_interface.h"

namespace tribus {
namespace {

void log_interface(const Appliance& appliance, const PortPlan& plan) {
    const auto interface = query_can_interface(plan.config.device);
    if (!interface) {
        return;
    }
    log_info("{}", summary(*interface));
    const bool sends = first_of(plan.wiring.stations, StationKind::output).has_value();
    for (const std::string& sentence : advice(*interface, sends, appliance.uses_fd(plan.wiring))) {
        log_warning("{}: {}", interface->name, sentence);
    }
}

}  // namespace

CanReport::CanReport(const Appliance& appliance) {
    for (std::size_t port = 0; port < appliance.ports().size(); ++port) {
        if (appliance.ports()[port].config.medium->shape == WireShape::can_frames) {
            interfaces_[appliance.ports()[port].config.device].port = port;
        }
    }
}

void CanReport::start(const Appliance& appliance) {
    for (const auto& [name, memory] : interfaces_) {
        log_interface(appliance, appliance.ports()[memory.port]);
    }
}

void CanReport::go_on_from(const CanReport& before, const Appliance& appliance) {
    for (auto& [name, memory] : interfaces_) {
        const auto known = before.interfaces_.find(name);
        if (known == before.interfaces_.end()) {
            continue;
        }
        const std::size_t port = std::exchange(memory, known->second).port;
        memory.port = port;
        // An interface that was reopened counts from zero.
        memory.receive_overflows =
            std::min(memory.receive_overflows, appliance.can_status(port).counts.receive_overflows);
    }
}

void CanReport::look_at_overflows(const std::string& name, const CanLinkStatus& status,
                                  Memory& memory, Instant now) {
    const std::uint64_t lost = status.counts.receive_overflows - memory.receive_overflows;
    if (lost == 0) {
        return;
    }
    if (const auto swallowed = memory.overflow_limit.pass(now)) {
        log_warning("interface {}: {} lost because they arrived faster than they were read{}", name,
                    counted(lost, "frame"), swallowed_note(*swallowed));
    }
    memory.receive_overflows = status.counts.receive_overflows;
}

void CanReport::look(const Appliance& appliance, std::span<const BusOffWatch::Restart> restarts,
                     Instant now) {
    for (auto& [name, memory] : interfaces_) {
        const CanLinkStatus status = appliance.can_status(memory.port);
        const LogFields fields({"TRIBUS_INTERFACE", name});
        look_at_overflows(name, status, memory, now);
    }
    for (const BusOffWatch::Restart& restart : restarts) {
        const LogFields fields({"TRIBUS_INTERFACE", restart.interface});
        if (const auto swallowed = interfaces_[restart.interface].limit.pass(now)) {
            const bool done = restart.error.empty();
            log_at(done ? LogLevel::info : LogLevel::warning, "{}{}",
                   done ? fmt::format("interface {}: restarted after bus-off", restart.interface)
                        : restart.error,
                   swallowed_note(*swallowed));
        }
    }
}

}  // namespace tribus
