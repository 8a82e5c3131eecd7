#include "config/read/dronecan.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "core/quotes.h"
#include "pipelines/dronecan/node_settings.h"
#include "transports/links/can/can_medium.h"

namespace tribus {
namespace {

/// `name` is not empty.
bool is_node_name(std::string_view name) {
    return name.size() <= dronecan::kLongestNodeName && std::ranges::all_of(name, [](char c) {
               return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
                      c == '-';
           });
}

}  // namespace

DroneCanDraft read_dronecan(const Entry& entry, const Table& table, Reading reading) {
    const std::string title = fmt::format("[dronecan.{}]", entry.key);
    const TableContent content =
        read_table({table, entry.value.where, title}, dronecan_keys(), reading);
    DroneCanDraft draft;
    draft.where = entry.where;
    draft.config.name = entry.key;
    draft.config.port.medium = &kCanMedium;
    content.read_into(draft.config.port);
    draft.config.port.where = content.where("interface");
    content.read_into(draft.config);
    if (content.given("node_id")) {
        draft.node_id = content.where("node_id");
    }
    draft.sound = content.sound("interface") && content.given("interface") &&
                  content.sound("node_id") && content.sound("dynamic");
    if (content.sound("name") && !is_node_name(draft.config.node_name)) {
        reading.mistakes.add(
            content.where("name"),
            fmt::format("{} is not a node name; allowed: 1 to {} small letters, digits, \".\", "
                        "\"_\" and \"-\"",
                        in_quotes(draft.config.node_name), dronecan::kLongestNodeName));
    }
    return draft;
}

}  // namespace tribus
