#include "app/mqtt/discovery.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/client/status_fields.h"
#include "app/mqtt/report.h"
#include "core/link_cause.h"

namespace tribus::mqtt {
namespace {

using namespace status_fields;
using OrderedJson = nlohmann::ordered_json;

/// Home Assistant shows "unavailable" if no status came for so long; one comes each second.
constexpr int kExpireAfterSeconds = 5;
constexpr std::array<std::string_view, 5> kOutputStates{"control", "hold", "failsafe", "silent",
                                                        "cannot_send"};

OrderedJson cause_words() {
    OrderedJson words = OrderedJson::array();
    for (std::size_t i = 0; i < kLinkCauseCount; ++i) {
        std::string word(name_of(static_cast<LinkCause>(i)));
        std::ranges::replace(word, ' ', '_');
        words.push_back(std::move(word));
    }
    return words;
}

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

    void add_input(const std::string& name) {
        OrderedJson good = entity("binary_sensor", "input", name, "Input " + name);
        good["device_class"] = "connectivity";
        good["value_template"] =
            fmt::format("{{{{ 'ON' if {} else 'OFF' }}}}", member("inputs", name, "good"));
        put(std::move(good));
        OrderedJson cause = entity("sensor", "cause", name, "Input " + name + " cause");
        cause["device_class"] = "enum";
        cause["options"] = cause_words();
        cause["value_template"] = in_braces(member("inputs", name, "cause"));
        put(std::move(cause));
    }
    void add_output(const std::string& name) {
        OrderedJson state = entity("sensor", "output", name, "Output " + name);
        state["device_class"] = "enum";
        state["options"] = kOutputStates;
        state["value_template"] = in_braces(member("outputs", name, "state"));
        put(std::move(state));
    }
    void add_value(const std::string& name, const std::string& unit) {
        OrderedJson value = entity("sensor", "value", name, name);
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
    OrderedJson entity(std::string_view platform, std::string_view kind, std::string_view name,
                       const std::string& shown) const {
        return {{"platform", platform},
                {"unique_id", id_of({board_, daemon_, kind, name})},
                {"name", shown},
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
    for (const Json& input : list(status, "inputs")) {
        components.add_input(raw_text(input, "name"));
    }
    for (const Json& output : list(status, "outputs")) {
        components.add_output(raw_text(output, "name"));
    }
    for (const Json& value : list(status, "values")) {
        if (is_told(value)) {
            components.add_value(raw_text(value, "name"), raw_text(value, "unit"));
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
