#include "config/build/dronecan.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>

#include "transports/codecs/dronecan/dronecan.h"
#include "transports/codecs/dronecan/types_node.h"

namespace tribus {
namespace {

std::int64_t microseconds(Duration duration) {
    return std::chrono::duration_cast<std::chrono::microseconds>(duration).count();
}

/// FNV-1a: each byte changes all later bits. The unique id is no secret, but must not reveal the
/// machine id.
std::uint64_t hash(std::uint64_t seed, std::string_view text) {
    constexpr std::uint64_t kPrime = 0x100000001B3;
    std::uint64_t value = 0xCBF29CE484222325 ^ seed;
    for (const char letter : text) {
        value = (value ^ static_cast<unsigned char>(letter)) * kPrime;
    }
    return value;
}

/// Includes the file, because several programs may use one interface of a machine, each with its
/// own file.
dronecan::UniqueId unique_id(MachineId machine, std::string_view interface, std::string_view file) {
    const std::string all = fmt::format("tribus {} {} {}", machine, interface, file);
    dronecan::UniqueId id{};
    constexpr std::size_t kHalf = 8;
    for (std::size_t i = 0; i < id.size(); ++i) {
        id[i] = static_cast<std::uint8_t>(hash(1 + i / kHalf, all) >> 8 * (i % kHalf));
    }
    return id;
}

std::string_view message_name(const OutputConfig& output) {
    const auto carries = output.settings.get_or<std::string>("carries", "rc");
    return carries == "rc" ? "RCInput" : carries == "servos" ? "ArrayCommand" : "RawCommand";
}

class NodePlans {
  public:
    NodePlans(const Configuration& configuration, MachineId machine)
        : configuration_(configuration), machine_(machine) {}

    std::vector<NodePlan> make() {
        for (const DroneCanConfig& config : configuration_.dronecan) {
            dronecan::NodeSettings& node = node_of(config.port);
            node.id = config.node_id.value_or(dronecan::kNobody);
            node.dynamic = config.dynamic;
            node.name = config.node_name;
            node.may_restart = config.allow_restart;
            node.may_write = config.allow_writes;
        }
        for (std::size_t i = 0; i < configuration_.outputs.size(); ++i) {
            if (configuration_.outputs[i].protocol == &kDroneCanProtocol) {
                add_output(i);
            }
        }
        for (NodePlan& plan : plans_) {
            auto& parameters = plan.settings.parameters;
            const std::int64_t id = plan.settings.id;
            parameters.insert(parameters.begin(), {.name = "uavcan.node_id",
                                                   .value = id,
                                                   .at_start = id,
                                                   .least = 0,
                                                   .most = dronecan::kMostNodeId});
        }
        return std::move(plans_);
    }

  private:
    dronecan::NodeSettings& node_of(const PortConfig& port) {
        const auto known = node_on(plans_, port.device);
        if (known) {
            return plans_[*known].settings;
        }
        dronecan::NodeSettings& made = plans_.emplace_back(NodePlan{port, {}}).settings;
        made.name = "org.tribus";
        made.unique_id = unique_id(machine_, port.device, configuration_.file);
        made.seed = hash(0, std::string_view(reinterpret_cast<const char*>(made.unique_id.data()),
                                             made.unique_id.size()));
        made.version_major = TRIBUS_VERSION_MAJOR;
        made.version_minor = TRIBUS_VERSION_MINOR;
        return made;
    }

    void add_output(std::size_t index) {
        const OutputConfig& output = configuration_.outputs[index];
        dronecan::NodeSettings& node = node_of(output.port);
        if (const auto* id = output.settings.find_as<std::int64_t>("node_id")) {
            node.id = static_cast<dronecan::NodeId>(*id);
        }
        const std::int64_t period = microseconds(output.schedule.period);
        const std::int64_t least = std::min(period, microseconds(output.protocol->least_period));
        const Duration most =
            output.protocol->most_period(output.settings).value_or(kMostOutputPeriod);
        node.parameters.push_back({.name = fmt::format("uavcan.pubp-{}", message_name(output)),
                                   .value = period,
                                   .at_start = period,
                                   .least = least,
                                   .most = microseconds(most),
                                   .output = index});
    }

    const Configuration& configuration_;
    MachineId machine_;
    std::vector<NodePlan> plans_;
};

}  // namespace

std::vector<NodePlan> plan_nodes(const Configuration& configuration, MachineId machine) {
    return NodePlans(configuration, machine).make();
}

std::optional<std::size_t> node_on(const std::vector<NodePlan>& plans, std::string_view interface) {
    const auto found = std::ranges::find_if(
        plans, [&](const NodePlan& plan) { return plan.port.device == interface; });
    return found == plans.end() ? std::nullopt
                                : std::optional(static_cast<std::size_t>(found - plans.begin()));
}

}  // namespace tribus
