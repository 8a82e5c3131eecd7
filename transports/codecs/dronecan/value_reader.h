#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string_view>

#include "transports/codecs/can_value_reader.h"
#include "transports/codecs/dronecan/source.h"

/// The return path: what batteries, motors, tanks and sensors say on the bus becomes numbers.
namespace tribus::dronecan {

/// Names of the messages that are read. Facts: docs/protocols/can.md, "DroneCAN: telemetry".
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

/// The field by which a node tells several of the same message apart, "battery_id"; empty where
/// there is none. `message` is one of kValueMessages.
std::string_view instance_field(std::string_view message);

/// Reads that message, one of kValueMessages, from the chosen source or else from the first that is
/// heard. Its values are the numbers of the message, "voltage" or "ned_velocity[2]", and of Fix2
/// "ground_speed". What the sender does not know is not available: floats that are not finite,
/// codes for "unknown", items that an array could have and has not, and of a position all that its
/// fix does not give. `fd`: frames of CAN FD are read too.
std::unique_ptr<CanValueReader> make_value_reader(std::string_view message,
                                                  const SourceChoice& source, bool fd);

}  // namespace tribus::dronecan
