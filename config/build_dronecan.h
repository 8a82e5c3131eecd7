#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema.h"
#include "pipelines/dronecan/node_settings.h"

namespace tribus {

/// What tells this machine from all others, such as /etc/machine-id; empty: it is not known.
using MachineId = std::string_view;

/// The node of one interface: that of [dronecan.NAME], or else of the outputs there that give an
/// id.
struct NodePlan {
    PortConfig port;
    dronecan::NodeSettings settings;
};

/// One for each interface where the configuration makes this program a node.
std::vector<NodePlan> plan_nodes(const Configuration& configuration, MachineId machine);

/// The place of that interface's node among the plans.
std::optional<std::size_t> node_on(const std::vector<NodePlan>& plans, std::string_view interface);

}  // namespace tribus
