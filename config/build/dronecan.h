#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema/schema.h"
#include "pipelines/dronecan/node_settings.h"

namespace tribus {

/// Identifies this machine, such as the content of /etc/machine-id. Empty: unknown.
using MachineId = std::string_view;

/// The DroneCAN node of one interface, from [dronecan.NAME] or from the outputs there that have a
/// node_id.
struct NodePlan {
    PortConfig port;
    dronecan::NodeSettings settings;
};

/// One plan for each interface on which the configuration makes this program a node.
std::vector<NodePlan> plan_nodes(const Configuration& configuration, MachineId machine);

/// Index of the plan for that interface.
std::optional<std::size_t> node_on(const std::vector<NodePlan>& plans, std::string_view interface);

}  // namespace tribus
