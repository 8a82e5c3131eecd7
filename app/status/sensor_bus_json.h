#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/status/status.h"
#include "config/schema/schema.h"
#include "pipelines/values/value_engine.h"

namespace tribus {

/// A sensor bus in a status. Pure.
nlohmann::ordered_json sensor_bus_json(const SensorBusConfig& config, const SensorBusState& state,
                                       const StatusReport& report);

}  // namespace tribus
