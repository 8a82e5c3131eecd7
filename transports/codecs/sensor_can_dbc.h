#pragma once

#include <string>

#include "transports/codecs/ibus_sensor_types.h"
#include "transports/codecs/sensor_can.h"

namespace tribus {

/// The DBC text of the readings of a sensor bus: a message for each address, with a page for each
/// of these types whose value has at most 4 bytes. Of `format` it takes the ids;
/// deploy/can/sensors.dbc is that of the defaults. Pure and reentrant.
std::string sensor_can_dbc(const SensorCanFormat& format = {},
                           const SensorTypes& types = SensorTypes());

}  // namespace tribus
