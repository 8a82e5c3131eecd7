#include "config/check/dronecan.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/quotes.h"
#include "transports/codecs/dronecan/dronecan.h"

namespace tribus {
namespace {

/// The node that a table defines for an interface, and its place in the file.
struct NodeClaim {
    std::optional<std::uint8_t> id;
    bool dynamic = false;
    std::string who;
    Location where;
};

bool sends_dronecan(const OutputDraft& output) {
    return output.port_sound && output.settings_sound &&
           output.config.protocol == &kDroneCanProtocol;
}

std::optional<std::uint8_t> own_id(const OutputConfig& output) {
    const auto* id = output.settings.find_as<std::int64_t>("node_id");
    return id == nullptr ? std::nullopt : std::optional(static_cast<std::uint8_t>(*id));
}

class NodeChecks {
  public:
    NodeChecks(const Draft& draft, Mistakes& mistakes) : draft_(draft), mistakes_(mistakes) {}

    void run() {
        for (const DroneCanDraft& node : draft_.dronecan) {
            if (node.sound) {
                claim_table(node);
            }
        }
        for (const OutputDraft& output : draft_.outputs) {
            if (sends_dronecan(output)) {
                claim_output(output);
            }
        }
        for (const OutputDraft& output : draft_.outputs) {
            if (sends_dronecan(output)) {
                check_id(output);
                check_twice(output);
            }
        }
        for (const DroneCanDraft& node : draft_.dronecan) {
            if (node.sound) {
                check_table(node);
            }
        }
    }

  private:
    void claim_table(const DroneCanDraft& node) {
        const PortConfig& port = node.config.port;
        const std::string who = fmt::format("[dronecan.{}]", node.config.name);
        const auto [claim, first] =
            claims_.try_emplace(port.device, NodeClaim{node.config.node_id, node.config.dynamic,
                                                       who, node.node_id.value_or(port.where)});
        if (!first) {
            mistakes_.add(port.where,
                          fmt::format("{} is already a node on {}; allowed: one node on an "
                                      "interface, for all its outputs",
                                      claim->second.who, in_quotes(port.device)));
        }
    }

    void claim_output(const OutputDraft& output) {
        const auto id = own_id(output.config);
        if (!id) {
            return;
        }
        const std::string who = fmt::format("[output.{}]", output.config.name);
        const auto [claim, first] = claims_.try_emplace(
            output.config.port.device, NodeClaim{.id = id, .who = who, .where = output.where});
        NodeClaim& known = claim->second;
        if (first || known.id == id) {
            return;
        }
        if (!known.id) {
            known.id = id;
            return;
        }
        mistakes_.add(output.where,
                      fmt::format("the node_id of {} is {}, that of {} in line {} is {}; allowed: "
                                  "one node on an interface, for all its outputs",
                                  who, *id, known.who, known.where.line, *known.id));
    }

    void check_id(const OutputDraft& output) {
        const auto claim = claims_.find(output.config.port.device);
        if (claim == claims_.end() || (!claim->second.id && !claim->second.dynamic)) {
            mistakes_.add(output.where,
                          fmt::format("[output.{}] has no node_id; required: one of 1 to 125 that "
                                      "no other node on {} has, here or in a table "
                                      "[dronecan.NAME] with that interface",
                                      output.config.name, in_quotes(output.config.port.device)));
        }
    }

    void check_table(const DroneCanDraft& node) {
        const auto claim = claims_.find(node.config.port.device);
        if (claim != claims_.end() && !claim->second.id && !node.config.dynamic) {
            mistakes_.add(node.where,
                          fmt::format("[dronecan.{}] has no node_id; required: one of 1 to 125 "
                                      "that no other node on {} has, or dynamic = true",
                                      node.config.name, in_quotes(node.config.port.device)));
        }
    }

    /// Two outputs that send the same message cannot be distinguished by readers.
    void check_twice(const OutputDraft& output) {
        const SettingValues& settings = output.config.settings;
        const std::string message =
            fmt::format("{} {}", settings.get_or<std::string>("carries", "rc"),
                        settings.get_or<std::int64_t>("receiver", 0));
        const auto [known, first] =
            sent_.try_emplace(fmt::format("{} {}", output.config.port.device, message), &output);
        if (!first) {
            mistakes_.add(
                output.where,
                fmt::format(
                    "[output.{}] in line {} sends the same message on {}; allowed: one output for "
                    "each message that a node sends, or carries = \"rc\" with another \"receiver\"",
                    known->second->config.name, known->second->where.line,
                    in_quotes(output.config.port.device)));
        }
    }

    const Draft& draft_;
    Mistakes& mistakes_;
    std::map<std::string, NodeClaim> claims_;         ///< by interface
    std::map<std::string, const OutputDraft*> sent_;  ///< by interface and message
};

}  // namespace

void check_dronecan(const Draft& draft, Mistakes& mistakes) {
    NodeChecks(draft, mistakes).run();
}

}  // namespace tribus
