#include "config/show/effective_values.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <variant>

#include <nlohmann/json.hpp>

#include "config/read/values.h"
#include "config/show/fields_json.h"

namespace tribus {
namespace {

using Json = nlohmann::ordered_json;

Json sensor_json(const SensorConfig& sensor) {
    Json json = Json::object();
    json["type"] = sensor.type.name;
    if (sensor.type.fields.size() == 1) {
        json["value"] = sensor.values.front();
    } else {
        for (std::size_t i = 0; i < sensor.values.size(); ++i) {
            if (!sensor.values[i].empty()) {
                json["values"][sensor.type.fields[i].name] = sensor.values[i];
            }
        }
    }
    json.update(fields_json(sensor, sensor_keys()));
    return json;
}

}  // namespace

Json sensor_bus_json(const SensorBusConfig& bus) {
    Json json = fields_json(bus.port, sensor_bus_keys());
    json.update(in_order_of_rows(
        fields_json(bus, sensor_bus_keys()), sensor_bus_keys(), [&](std::string_view key) {
            return bus_role_has(bus.role, key) && (key != "address" || !bus.chain);
        }));
    for (const SensorConfig& sensor : bus.sensors) {
        json["sensor"].push_back(sensor_json(sensor));
    }
    return json;
}

Json sensor_type_json(const SensorType& type) {
    Json json = fields_json(type, sensor_type_keys());
    json.update(fields_json(type.fields.front(), sensor_type_keys()));
    return json;
}

Json named_values_json(const ValuesConfig& named) {
    if (const auto* constant = std::get_if<ConstantConfig>(&named.source)) {
        return fields_json(*constant, values_keys());
    }
    const auto& message = std::get<ValueMessageConfig>(named.source);
    const std::string place(message.port.medium->place.key);
    Json json = Json::object();
    json[place] = message.port.device;
    if (message.port.medium->has_line) {
        json["baud"] = message.port.line.baud;
    }
    json.update(values_json(message.port.settings, values_keys()));
    std::visit([&json](const auto& layout) { json.update(fields_json(layout, values_keys())); },
               message.layout);
    json.update(fields_json(message, values_keys()));
    for (const auto& [name, signal] : message.names) {
        json["signals"][name] = signal;
    }
    return in_order_of_rows(json, values_keys());
}

Json dronecan_json(const DroneCanConfig& node) {
    Json json = fields_json(node.port, dronecan_keys());
    json.update(fields_json(node, dronecan_keys()));
    return json;
}

}  // namespace tribus
