#pragma once

#include <nlohmann/json_fwd.hpp>

#include "config/schema/schema.h"

/// [sensor_bus], [sensor_type], [values] and [dronecan] of the effective configuration.
namespace tribus {

nlohmann::ordered_json sensor_bus_json(const SensorBusConfig& bus);
nlohmann::ordered_json sensor_type_json(const SensorType& type);
nlohmann::ordered_json named_values_json(const ValuesConfig& values);
nlohmann::ordered_json dronecan_json(const DroneCanConfig& node);

}  // namespace tribus
