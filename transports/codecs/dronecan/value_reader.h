#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string_view>

#include "transports/codecs/can_value_reader.h"
#include "transports/codecs/dronecan/source.h"

/// Telemetry: reads numbers from the messages of batteries, motors, tanks and sensors.
namespace tribus::dronecan {

/// Names of the messages that can be read (docs/protocols/can.md, "DroneCAN: telemetry").
inline constexpr std::array<std::string_view, 12> kValueMessages{
    "uavcan.equipment.power.BatteryInfo",
    "uavcan.equipment.power.CircuitStatus",
    "uavcan.equipment.esc.Status",
    "uavcan.equipment.esc.StatusExtended",
    "uavcan.equipment.gnss.Fix2",
    "uavcan.equipment.device.Temperature",
    "uavcan.equipment.air_data.StaticPressure",
    "uavcan.equipment.air_data.StaticTemperature",
    "uavcan.equipment.ice.FuelTankStatus",
    "dronecan.sensors.rpm.RPM",
    "ardupilot.equipment.power.BatteryCells",
    "ardupilot.equipment.power.BatteryInfoAux",
};

/// Name of the field that distinguishes several of the same message on one node, such as
/// "battery_id"; empty if there is none. `message` is one of kValueMessages. Pure and reentrant.
std::string_view instance_field(std::string_view message);

/// Makes a reader of `message`, one of kValueMessages, from the chosen source, else from the first
/// one that is received. Its values are the numbers of the message, such as "voltage" or
/// "ned_velocity[2]", and for Fix2 also "ground_speed". Not available are floats that are not
/// finite, codes for "unknown", missing items of arrays, and the parts of a position that its fix
/// does not give. `fd`: reads CAN FD frames too.
std::unique_ptr<CanValueReader> make_value_reader(std::string_view message,
                                                  const SourceChoice& source, bool fd);

}  // namespace tribus::dronecan
