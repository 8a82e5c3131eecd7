#include "app/mqtt/discovery.h"

#include <initializer_list>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/client/status_fields.h"
#include "app/mqtt/report.h"
#include "app/status/fields.h"

namespace tribus::mqtt {
namespace {

using namespace status_fields;
using OrderedJson = nlohmann::ordered_json;

/// Home Assistant shows "unavailable" if no status came for so long; one comes each second.
constexpr int kExpireAfterSeconds = 5;
/// A text in a template, in single quotes.
std::string in_template(const std::string& text) {
    std::string quoted = "'";
    for (const char c : text) {
        quoted += c == '\'' || c == '\\' ? "\\" : "";
        quoted += c;
    }
    return quoted + "'";
}

/// The member of that name of a status in a template. A dot would find the method of a dict that
/// has the name.
std::string member(std::string_view kind, const std::string& name, std::string_view field) {
    return fmt::format("value_json['{}'][{}]['{}']", kind, in_template(name), field);
}

std::string in_braces(const std::string& expression) {
    return "{{ " + expression + " }}";
}

/// An id of Home Assistant, which takes [a-zA-Z0-9_-]: different parts make different ids.
std::string id_of(std::initializer_list<std::string_view> parts) {
    std::string id = "tribus";
    for (const std::string_view part : parts) {
        id += "--" + escaped(part, '-', "_");
    }
    return id;
}

/// Adds the components of one device.
class Components {
  public:
    Components(const DaemonTopics& topics, std::string board, std::string daemon)
        : topics_(topics), board_(std::move(board)), daemon_(std::move(daemon)) {}

    /// A fact of a part that is yes or no, or always one of some words.
    void add_fact(const PartKind& kind, const StatusField& row, const std::string& name) {
        const FieldOptions& options = row.options;
        const bool is_word = row.kind == FieldKind::word && !options.may_be_null;
        if (options.fleet.empty() || (row.kind != FieldKind::flag && !is_word)) {
            return;
        }
        OrderedJson fact = entity(is_word ? "sensor" : "binary_sensor", kind, name, options.fleet);
        const std::string value = member(kind.fleet, name, options.fleet);
        fact["device_class"] = is_word ? "enum" : "connectivity";
        if (is_word) {
            fact["options"] = options.words;
            fact["value_template"] = in_braces(value);
        } else {
            fact["value_template"] = fmt::format("{{{{ 'ON' if {} else 'OFF' }}}}", value);
        }
        put(std::move(fact));
    }
    void add_value(const PartKind& kind, const std::string& name, const std::string& unit) {
        OrderedJson value = entity("sensor", kind, name, "number");
        value["name"] = name;
        value["state_class"] = "measurement";
        if (!unit.empty()) {
            value["unit_of_measurement"] = unit;
        }
        // A stale value is null, which Home Assistant shows as "unknown".
        value["value_template"] = in_braces(member("values", name, "number"));
        put(std::move(value));
    }
    void add_events() {
        OrderedJson event{{"platform", "event"},
                          {"unique_id", id_of({board_, daemon_, "event"})},
                          {"name", "Event"},
                          {"event_types", event_types()},
                          {"state_topic", topics_.event},
                          {"qos", 1}};
        put(std::move(event));
    }
    OrderedJson take() { return std::move(components_); }

  private:
    OrderedJson entity(std::string_view platform, const PartKind& kind, std::string_view name,
                       std::string_view fact) const {
        return {{"platform", platform},
                {"unique_id", id_of({board_, daemon_, kind.word, name, fact})},
                {"name", fmt::format("{} {} {}", kind.word, name, fact)},
                {"state_topic", topics_.status},
                {"expire_after", kExpireAfterSeconds}};
    }
    void put(OrderedJson component) {
        const std::string id = component["unique_id"];
        components_[id] = std::move(component);
    }

    const DaemonTopics& topics_;
    std::string board_;
    std::string daemon_;
    OrderedJson components_ = OrderedJson::object();
};

}  // namespace

DaemonTopics topics_of(const std::string& prefix, const std::string& board,
                       const std::string& daemon) {
    const std::string of_board = fmt::format("{}/{}", prefix, topic_level(board));
    const std::string of_daemon = fmt::format("{}/{}", of_board, topic_level(daemon));
    return {.board_availability = of_board + "/availability",
            .availability = of_daemon + "/availability",
            .status = of_daemon + "/status",
            .event = of_daemon + "/event"};
}

std::string discovery_topic(const std::string& prefix, const std::string& board,
                            const std::string& daemon) {
    return fmt::format("{}/device/{}/config", prefix, id_of({board, daemon}));
}

std::string discovery_payload(const DaemonTopics& topics, const std::string& board,
                              const nlohmann::json& status, const std::string& version) {
    const std::string daemon = raw_text(status, "name");
    const std::string device = id_of({board, daemon});
    Components components(topics, board, daemon);
    for (const PartKind& kind : part_kinds()) {
        if (kind.fleet.empty()) {
            continue;
        }
        for (const Json& part : list(status, std::string(kind.list).c_str())) {
            const std::string name = raw_text(part, "name");
            if (kind.list == "values" && is_told(part)) {
                components.add_value(kind, name, raw_text(part, "unit"));
            }
            for (const StatusField& row : kind.fields) {
                components.add_fact(kind, row, name);
            }
            if (field(part, "can").is_object()) {
                for (const StatusField& row : can_kind().fields) {
                    components.add_fact(kind, row, name);
                }
            }
        }
    }
    components.add_events();
    const OrderedJson json{
        {"device",
         {{"identifiers", {device}},
          {"name", fmt::format("{} on {}", daemon, board)},
          {"manufacturer", "tribus"},
          {"sw_version", version}}},
        {"origin", {{"name", "tribus-mqtt"}, {"sw_version", version}}},
        {"availability",
         {{{"topic", topics.board_availability}}, {{"topic", topics.availability}}}},
        {"availability_mode", "all"},
        {"components", components.take()}};
    return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

}  // namespace tribus::mqtt
