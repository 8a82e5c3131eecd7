#include "app/state_text/part_text.h"

#include <chrono>

#include <fmt/format.h>

namespace tribus {

bool is_fine(const OutputState& state) {
    return state.stage == OutputStage::control && state.outvoted == 0 &&
           state.hearing != Hearing::silent && state.hearing != Hearing::unreadable;
}

bool is_asked(const std::optional<Instant>& latest_request, Instant now) {
    constexpr Duration kRequestTimeout = std::chrono::seconds(1);
    return latest_request && now - *latest_request < kRequestTimeout;
}

std::string can_bus_text(CanBusState state, const std::string& name) {
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

std::string node_word(const dronecan::NodeState& state) {
    const bool online = state.stage == dronecan::NodeStage::online;
    return std::string(kNodeStageWords[static_cast<std::size_t>(state.stage)]) +
           (online ? fmt::format(" {}", state.id) : "");
}

std::string node_text(const dronecan::NodeState& state, int wanted) {
    switch (state.stage) {
        case dronecan::NodeStage::online:
            return fmt::format("this program is DroneCAN node {}", state.id);
        case dronecan::NodeStage::conflict:
            return fmt::format(
                "another DroneCAN node has the id {} too; nothing is sent until it has been silent "
                "for 5 s; give one of the two another node_id",
                wanted);
        case dronecan::NodeStage::allocating:
            break;
    }
    return "another DroneCAN node has the same id; nothing is sent until an allocator assigns "
           "another one";
}

}  // namespace tribus
