#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "core/time.h"
#include "pipelines/dronecan/node.h"
#include "pipelines/engine/output.h"
#include "transports/links/can/can_link.h"

namespace tribus {

/// The state of a device, interface or GPIO line that is missing.
inline constexpr std::string_view kGoneText = "is gone; waiting for it";

/// Whether the user has nothing to do about an output in this state.
bool is_fine(const OutputState& state);

/// Whether a receiver asks the sensors of a bus: one that is on sends a request each 7.7 ms.
bool is_asked(const std::optional<Instant>& latest_request, Instant now);

/// The state of a CAN interface in words: "works".
std::string can_bus_text(CanBusState state, const std::string& name);

/// Words for `NodeStage`, in its order.
inline constexpr std::array<std::string_view, 3> kNodeStageWords{"allocating", "online",
                                                                 "conflict"};
/// The state of a DroneCAN node of this program in a word, with its id if it has one: "online 42".
std::string node_word(const dronecan::NodeState& state);
/// The same in words. `wanted`: the id that it is configured with.
std::string node_text(const dronecan::NodeState& state, int wanted);

}  // namespace tribus
