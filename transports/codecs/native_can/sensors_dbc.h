#pragma once

#include <string>

#include "transports/codecs/ibus_sensor/types.h"
#include "transports/codecs/native_can/sensors.h"

namespace tribus {

/// Returns the DBC text of the readings of a sensor bus: one message for each address, with one
/// page for each type whose value has at most 4 bytes. Only the ids of `format` are used;
/// deploy/can/sensors.dbc is the text of the default format. Pure and reentrant.
std::string sensor_can_dbc(const SensorCanFormat& format = {},
                           const SensorTypes& types = SensorTypes());

}  // namespace tribus
