#include "app/mqtt/discovery.h"

#include <array>
#include <string_view>

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

/// Adds the components of one device.
class Components {
  public:
    Components(const DaemonTopics& topics, std::string device)
        : topics_(topics), device_(std::move(device)) {}

    void add_input(const std::string& name) {
        const std::string input = fmt::format("value_json.inputs[{}]", in_template(name));
        OrderedJson good = entity("binary_sensor", "input_" + name, "Input " + name);
        good["device_class"] = "connectivity";
        good["value_template"] = fmt::format("{{{{ 'ON' if {}.good else 'OFF' }}}}", input);
        put(std::move(good));
        OrderedJson cause =
            entity("sensor", "input_" + name + "_cause", "Input " + name + " cause");
        cause["device_class"] = "enum";
        cause["options"] = cause_words();
        cause["value_template"] = fmt::format("{{{{ {}.cause }}}}", input);
        put(std::move(cause));
    }
    void add_output(const std::string& name) {
        OrderedJson state = entity("sensor", "output_" + name, "Output " + name);
        state["device_class"] = "enum";
        state["options"] = kOutputStates;
        state["value_template"] =
            fmt::format("{{{{ value_json.outputs[{}].state }}}}", in_template(name));
        put(std::move(state));
    }
    void add_value(const std::string& name, const std::string& unit) {
        OrderedJson value = entity("sensor", "value_" + name, name);
        value["state_class"] = "measurement";
        if (!unit.empty()) {
            value["unit_of_measurement"] = unit;
        }
        // A stale value is null, which Home Assistant shows as "unknown".
        value["value_template"] =
            fmt::format("{{{{ value_json.values[{}].number }}}}", in_template(name));
        put(std::move(value));
    }
    void add_events() {
        OrderedJson event{
            {"platform", "event"},          {"unique_id", device_ + "_event"}, {"name", "Event"},
            {"event_types", event_types()}, {"state_topic", topics_.event},    {"qos", 1}};
        put(std::move(event));
    }
    OrderedJson take() { return std::move(components_); }

  private:
    OrderedJson entity(std::string_view platform, const std::string& id,
                       const std::string& name) const {
        return {{"platform", platform},
                {"unique_id", device_ + "_" + topic_level(id)},
                {"name", name},
                {"state_topic", topics_.status},
                {"expire_after", kExpireAfterSeconds}};
    }
    void put(OrderedJson component) {
        const std::string id = component["unique_id"];
        components_[id] = std::move(component);
    }

    const DaemonTopics& topics_;
    std::string device_;
    OrderedJson components_ = OrderedJson::object();
};

std::string device_id(const std::string& board, const std::string& daemon) {
    return fmt::format("tribus_{}_{}", topic_level(board), topic_level(daemon));
}

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
    return fmt::format("{}/device/{}/config", prefix, device_id(board, daemon));
}

std::string discovery_payload(const DaemonTopics& topics, const std::string& board,
                              const nlohmann::json& status, const std::string& version) {
    const std::string daemon = raw_text(status, "name");
    const std::string device = device_id(board, daemon);
    Components components(topics, device);
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
