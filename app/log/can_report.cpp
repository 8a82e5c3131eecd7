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

/// Longer than the kernel's own restart takes, if it is configured.
constexpr Duration kBusOffPatience = std::chrono::seconds(1);

std::string state_text(CanBusState state, const std::string& name) {
    switch (state) {
        case CanBusState::ready:
            return "works";
        case CanBusState::warning:
            return "many errors on the bus; check bit rate, termination and wiring";
        case CanBusState::passive:
            return "error-passive: few frames get through; check bit rate, termination and wiring";
        case CanBusState::stalled:
            return "frames are not sent: no other node acknowledges them, or the bus is full; old "
                   "frames will not be sent later";
        case CanBusState::bus_off:
            return "bus-off: the controller left the bus after too many errors; check bit rate, "
                   "termination and wiring";
        case CanBusState::down:
            return fmt::format("is down; `ip link set {} up` brings it up", name);
    }
    return "";
}

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

void CanReport::look_at_state(const std::string& name, const CanLinkStatus& status, Memory& memory,
                              Instant now) {
    if (status.state != memory.said.seen()) {
        memory.bus_off_since =
            status.state == CanBusState::bus_off ? std::optional(now) : std::nullopt;
    }
    if (const auto swallowed = memory.said.look(status.state, memory.limit, now)) {
        const bool fine = status.state == CanBusState::ready;
        log_at(fine ? LogLevel::info : LogLevel::warning, "interface {}: {}{}", name,
               state_text(status.state, name), swallowed_note(*swallowed));
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

/// With restart-ms 0 the controller stays off until somebody restarts it.
void CanReport::end_bus_off(const std::string& name, Memory& memory, Instant now) {
    if (!memory.bus_off_since || now - *memory.bus_off_since < kBusOffPatience) {
        return;
    }
    memory.bus_off_since = now;
    const auto interface = query_can_interface(name);
    if (!interface || interface->state != CanControllerState::bus_off ||
        interface->restart_ms.value_or(0) != 0) {
        return;
    }
    const auto restarted = restart_can_interface(name);
    if (const auto swallowed = memory.limit.pass(now)) {
        if (restarted) {
            log_info("interface {}: restarted after bus-off{}", name, swallowed_note(*swallowed));
        } else {
            log_warning("{}{}", restarted.error(), swallowed_note(*swallowed));
        }
    }
}

void CanReport::look(const Appliance& appliance, Instant now) {
    for (auto& [name, memory] : interfaces_) {
        const CanLinkStatus status = appliance.can_status(memory.port);
        const LogFields fields({"TRIBUS_INTERFACE", name});
        look_at_state(name, status, memory, now);
        look_at_overflows(name, status, memory, now);
        end_bus_off(name, memory, now);
    }
}

}  // namespace tribus
