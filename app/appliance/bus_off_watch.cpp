#include "app/appliance/bus_off_watch.h"

#include "transports/links/can/can_interface.h"

namespace tribus {
namespace {

/// Longer than the kernel's own restart takes, if it is configured.
constexpr Duration kPatience = std::chrono::seconds(1);

}  // namespace

std::optional<BusOffWatch::Restart> BusOffWatch::look(const std::string& interface, bool off,
                                                      Instant now) {
    if (!off) {
        off_since_.erase(interface);
        return std::nullopt;
    }
    Instant& since = off_since_.try_emplace(interface, now).first->second;
    if (now - since < kPatience) {
        return std::nullopt;
    }
    since = now;
    const auto facts = query_can_interface(interface);
    if (!facts || facts->state != CanControllerState::bus_off ||
        facts->restart_ms.value_or(0) != 0) {
        return std::nullopt;
    }
    const auto restarted = restart_can_interface(interface);
    return Restart{interface, restarted ? "" : restarted.error()};
}

}  // namespace tribus
