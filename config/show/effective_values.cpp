#include "config/show/effective_values.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>

#include <nlohmann/json.hpp>

#include "config/keys/rows_values.h"
#include "config/show/effective_channels.h"

namespace tribus {
namespace {

using Json = nlohmann::ordered_json;

template <class Choices, class Enum>
std::string choice_name(const Choices& choices, Enum value) {
    return std::string(choices[static_cast<std::size_t>(value)]);
}

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
    if (sensor.scale) {
        json["scale"] = number_json(*sensor.scale);
    }
    if (sensor.offset != 0) {
        json["offset"] = number_json(sensor.offset);
    }
    if (sensor.not_available) {
        json["not_available"] = number_json(*sensor.not_available);
    }
    return json;
}

void set_sensor_role(const SensorBusConfig& bus, SettingValues& values) {
    if (!bus.chain) {
        values.set("address", std::int64_t{bus.address});
    }
    values.set("chain", bus.chain);
    values.set("reply_after", bus.reply_after);
    values.set("reply_within", bus.reply_within);
}

void set_receiver_role(const SensorBusConfig& bus, SettingValues& values) {
    values.set("slot", bus.slot);
    values.set("power_up", bus.power_up);
    values.set("probe_every", std::int64_t{bus.probe_every});
    values.set("drop_after", std::int64_t{bus.drop_after});
    values.set("timeout", bus.timeout);
}

void set_dronecan_source(const DroneCanValueSource& source, SettingValues& values) {
    values.set("dronecan", source.message);
    if (source.from.node) {
        values.set("node", std::int64_t{*source.from.node});
    }
    if (source.from.instance) {
        values.set("instance", std::int64_t{*source.from.instance});
    }
    values.set("fd", source.fd);
}

}  // namespace

Json sensor_bus_json(const SensorBusConfig& bus) {
    SettingValues values;
    values.set("device", bus.port.device);
    values.set("role", std::string(bus.receiver ? "receiver" : "sensor"));
    values.set("wires", choice_name(key_rows::kWiresChoices, bus.wires));
    values.set("dialect", choice_name(kSensorDialectNames, bus.dialect));
    if (bus.receiver) {
        set_receiver_role(bus, values);
    } else {
        set_sensor_role(bus, values);
    }
    Json json = values_json(values, sensor_bus_keys());
    for (const SensorConfig& sensor : bus.sensors) {
        json["sensor"].push_back(sensor_json(sensor));
    }
    return json;
}

Json sensor_type_json(const SensorType& type) {
    const SensorField& field = type.fields.front();
    SettingValues values;
    values.set("id", std::int64_t{type.id});
    values.set("size", std::int64_t{type.size});
    values.set("signed", field.is_signed);
    values.set("scale", field.scale);
    values.set("offset", field.offset);
    if (!field.unit.empty()) {
        values.set("unit", field.unit);
    }
    if (field.not_available) {
        values.set("not_available", *field.not_available);
    }
    return values_json(values, sensor_type_keys());
}

Json named_values_json(const ValuesConfig& named) {
    SettingValues values;
    if (const auto* constant = std::get_if<ConstantConfig>(&named.source)) {
        values.set("constant", constant->number);
        if (!constant->unit.empty()) {
            values.set("unit", constant->unit);
        }
        return values_json(values, values_keys());
    }
    const auto& message = std::get<ValueMessageConfig>(named.source);
    values.set("interface", message.port.device);
    if (const auto* dbc = std::get_if<DbcValueSource>(&message.layout)) {
        values.set("dbc", dbc->dbc);
        values.set("message", dbc->message);
    } else {
        set_dronecan_source(std::get<DroneCanValueSource>(message.layout), values);
    }
    values.set("timeout", message.timeout);
    Json json = values_json(values, values_keys());
    for (const auto& [name, signal] : message.names) {
        json["signals"][name] = signal;
    }
    return json;
}

Json dronecan_json(const DroneCanConfig& node) {
    SettingValues values;
    values.set("interface", node.port.device);
    if (node.node_id) {
        values.set("node_id", std::int64_t{*node.node_id});
    }
    values.set("dynamic", node.dynamic);
    values.set("name", node.node_name);
    values.set("allow_restart", node.allow_restart);
    values.set("allow_writes", node.allow_writes);
    return values_json(values, dronecan_keys());
}

}  // namespace tribus
