#include "app/log/node_log.h"

#include <fmt/format.h>

#include "app/journal/log.h"
#include "app/journal/log_fields.h"
#include "app/journal/log_limit.h"
#include "config/build/dronecan.h"

namespace tribus {

NodeLog::NodeLog(const Appliance& appliance) {
    for (const NodePlan& plan : plan_nodes(appliance.configuration(), {})) {
        const dronecan::NodeSettings& node = plan.settings;
        nodes_.push_back(
            {.interface = plan.port.device,
             .wanted = node.id,
             .word = ChangeReport(node.dynamic ? Word{.stage = dronecan::NodeStage::allocating}
                                               : Word{.id = node.id})});
    }
}

void NodeLog::go_on_from(const NodeLog& before, std::span<const CarriedFrom> from) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (from[i]) {
            nodes_[i] = before.nodes_[*from[i]];
        }
    }
}

void NodeLog::look(const Appliance& appliance, Instant now) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        Memory& memory = nodes_[i];
        const dronecan::NodeReport report = appliance.node_report(i);
        const bool online = report.stage == dronecan::NodeStage::online;
        const Word word{report.stage, online ? report.id : dronecan::kNobody};
        if (const auto swallowed = memory.word.look(word, memory.limit, now)) {
            log_change(memory, swallowed_note(*swallowed));
        }
    }
}

void NodeLog::log_change(const Memory& memory, const std::string& note) {
    const LogFields fields({"TRIBUS_INTERFACE", memory.interface});
    switch (memory.word.reported().stage) {
        case dronecan::NodeStage::online:
            log_info("{}: this program is DroneCAN node {}{}", memory.interface,
                     memory.word.reported().id, note);
            break;
        case dronecan::NodeStage::conflict:
            log_error(
                "{}: another DroneCAN node has the id {} too; nothing is sent until it has been "
                "silent for 5 s; give one of the two another node_id{}",
                memory.interface, memory.wanted, note);
            break;
        case dronecan::NodeStage::allocating:
            log_warning(
                "{}: another DroneCAN node has the same id; nothing is sent until an allocator "
                "assigns another one{}",
                memory.interface, note);
            break;
    }
}

}  // namespace tribus
