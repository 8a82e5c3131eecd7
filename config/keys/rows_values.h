#pragma once

#include <array>
#include <string_view>

#include "config/keys/rows_ports.h"
#include "transports/codecs/dronecan/value_reader.h"
#include "transports/codecs/ibus_sensor/types.h"
#include "transports/registry/registry.h"

/// Rows of sensor buses, their types, and named values.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array kSensorKeys{
    Key{{.key = "type",
         .type = text,
         .required = true,
         .help = "Type of the sensor that the receiver shows, such as `external_voltage`, or "
                 "NAME of a `[sensor_type.NAME]`",
         .example = "\"external_voltage\""}},
    Key{{.key = "value",
         .type = text,
         .absent = "none; required, or `values`",
         .help = "Named value that is sent",
         .example = "\"battery.voltage\""}},
    Key{structure("values",
                  "Instead of `value`, for a type with several fields: `{ field = value }`",
                  "{ fix = \"gps.status\", satellites = \"gps.sats_used\" }", "none"),
        KeyKind::texts},
    row<&SensorConfig::scale>(
        {.key = "scale",
         .type = number,
         .absent = "the conversion of the value's unit to that of the type",
         .help = "The value is multiplied by this, to be in the unit of the type. Required "
                 "where a unit is not known",
         .example = "0.001"}),
    row<&SensorConfig::offset>({.key = "offset",
                                .type = number,
                                .help = "Is added to the value, after `scale`",
                                .example = "-100"}),
    row<&SensorConfig::not_available>(
        {.key = "not_available",
         .type = number,
         .absent = "the sensor does not answer",
         .help = "Number that is sent while there is no fresh value, if the type has no code "
                 "for \"not available\"",
         .example = "0"}),
};

inline constexpr std::array kSensorBusKeys{
    kDeviceKey,
    row<&SensorBusConfig::role>(
        {.key = "role",
         .required = true,
         .help = "What this program is on the bus. `sensor`: answers a receiver as the sensors "
                 "of `sensor`; `receiver`: finds sensors and asks them",
         .example = "\"sensor\""}),
    row<&SensorBusConfig::wires>(
        {.key = "wires",
         .help = "`one`: one wire for both directions, on which the port hears itself; `two`: a "
                 "wire for each direction; `auto`: finds out",
         .example = "\"one\""}),
    row<&SensorBusConfig::dialect>(
        {.key = "dialect",
         .help = "Maker or program whose meaning of the disputed sensor types counts",
         .example = "\"inav\""}),
    Key{structure("sensor",
                  "Role `sensor`: the sensors, in the order of their addresses, at most 15. "
                  "Written as tables `[[sensor_bus.NAME.sensor]]` or as a list",
                  "[{ type = \"external_voltage\", value = \"battery.voltage\" }]",
                  "none; role `sensor` requires it"),
        KeyKind::list, kSensorKeys},
    row<&SensorBusConfig::address>(
        {.key = "address",
         .least = 1,
         .most = 15,
         .help = "Role `sensor`: address of the first sensor; the others follow",
         .example = "3"}),
    row<&SensorBusConfig::chain>(
        {.key = "chain",
         .help = "Role `sensor`: true at the end of a daisy chain of genuine sensors. The first "
                 "sensor takes the address of the first discovery that comes, instead of "
                 "`address`",
         .example = "true"}),
    row<&SensorBusConfig::reply_after>(
        {.key = "reply_after",
         .least = 0,
         .most = 0.002,
         .help = "Role `sensor`: time from the request to its answer. Must be less than "
                 "`reply_within`",
         .example = "\"400us\""}),
    row<&SensorBusConfig::reply_within>(
        {.key = "reply_within",
         .least = 0.0002,
         .most = 0.003,
         .help = "Role `sensor`: an answer that would leave later than this after the request "
                 "is withheld",
         .example = "\"2ms\""}),
    row<&SensorBusConfig::slot>({.key = "slot",
                                 .least = 0.0035,
                                 .most = 0.1,
                                 .help = "Role `receiver`: time from one request to the next",
                                 .example = "\"10ms\""}),
    row<&SensorBusConfig::power_up>(
        {.key = "power_up",
         .help = "Role `receiver`: begins with the frames that genuine receivers send at "
                 "power-up",
         .example = "false"}),
    row<&SensorBusConfig::probe_every>(
        {.key = "probe_every",
         .least = 2,
         .most = 10000,
         .unit = "slots",
         .help = "Role `receiver`: one slot of so many looks for a further sensor",
         .example = "20"}),
    row<&SensorBusConfig::drop_after>(
        {.key = "drop_after",
         .least = 1,
         .most = 10000,
         .unit = "requests",
         .help = "Role `receiver`: a sensor is gone after so many requests in a row without an "
                 "answer",
         .example = "20"}),
    row<&SensorBusConfig::timeout>(
        {.key = "timeout",
         .least = 0.01,
         .most = 60,
         .help = "Role `receiver`: a value that was not renewed for this long is stale",
         .example = "\"5s\""}),
};

inline constexpr std::array kSensorTypeKeys{
    row<&SensorType::id>({.key = "id",
                          .required = true,
                          .least = 1,
                          .most = 254,
                          .help = "Number of the type on the wire",
                          .example = "0x50"}),
    row<&SensorType::size>({.key = "size",
                            .least = 1,
                            .most = 4,
                            .unit = "bytes",
                            .help = "Size of the value on the wire",
                            .example = "4"}),
    row<&SensorField::is_signed>({.key = "signed",
                                  .help = "`true`: the raw value is in two's complement",
                                  .example = "true"}),
    row<&SensorField::scale>({.key = "scale",
                              .type = number,
                              .help = "The number is the raw value * `scale` + `offset`; not 0",
                              .example = "0.01"}),
    row<&SensorField::offset>(
        {.key = "offset", .type = number, .help = "See `scale`", .example = "-40"}),
    row<&SensorField::unit>(
        {.key = "unit", .absent = "no unit", .help = "Unit of the number", .example = "\"V\""}),
    row<&SensorField::not_available>({.key = "not_available",
                                      .absent = "none",
                                      .least = -2147483648.0,
                                      .most = 4294967295.0,
                                      .help = "Raw value that means that there is no number",
                                      .example = "0xFFFF"}),
};

inline constexpr std::array kValuesKeys{
    row<&ConstantConfig::number>(
        {.key = "constant",
         .type = number,
         .absent = "the values are those of a message",
         .help = "A number that does not change; its name is NAME. Beside it only `unit`",
         .example = "6"}),
    row<&ConstantConfig::unit>(
        {.key = "unit", .absent = "no unit", .help = "Unit of `constant`", .example = "\"V\""}),
    row<&PortConfig::device>({.key = "interface",
                              .absent = "required with `dbc` and `dronecan`",
                              .help = "CAN interface that the message comes from",
                              .example = "\"can0\""}),
    row<&DbcValueSource::dbc>(
        {.key = "dbc",
         .absent = "required with `message`",
         .help = "DBC file that describes the message, from the folder of the configuration",
         .example = "\"telemetry.dbc\""}),
    row<&DbcValueSource::message>(
        {.key = "message",
         .absent = "required with `dbc`",
         .help = "Name of the message in the DBC file. Each of its signals is a value, "
                 "NAME.SIGNAL",
         .example = "\"Battery\""}),
    row<&DroneCanValueSource::message>(
        {.key = "dronecan",
         .type = choice,
         .absent = "the message is that of `dbc`",
         .choices = dronecan::kValueMessages,
         .help = "DroneCAN message, instead of `dbc` and `message`. Each of its numbers is a "
                 "value, NAME.FIELD",
         .example = "\"uavcan.equipment.power.BatteryInfo\""}),
    row<&DroneCanValueSource::from, &dronecan::SourceChoice::node>(
        {.key = "node",
         .absent = "the first one that is heard, until it has been silent for 3 s",
         .least = 1,
         .most = dronecan::kMostNodeId,
         .help = "With `dronecan`: node that is listened to",
         .example = "50"}),
    row<&DroneCanValueSource::from, &dronecan::SourceChoice::instance>(
        {.key = "instance",
         .absent = "the first one that is heard, until it has been silent for 3 s",
         .most = 65535,
         .help = "With `dronecan`: which one of several on the node, by its battery_id, "
                 "circuit_id, esc_index, device_id, fuel_tank_id or sensor_id",
         .example = "0"}),
    row<&DroneCanValueSource::fd>({.key = "fd",
                                   .absent = "`false`",
                                   .help = "With `dronecan`: frames of CAN FD are read too",
                                   .example = "true"}),
    row<&ByteValueSource::protocol>(
        {.key = "protocol",
         .type = choice,
         .absent = "the message is on CAN",
         .choices = kValueProtocols,
         .help = "Protocol of bytes whose messages are read, instead of a message on CAN. Each of "
                 "its numbers is a value, such as NAME.battery.voltage",
         .example = "\"crsf-telemetry\""}),
    row<&PortConfig::device>({.key = kDeviceSetting.key,
                              .absent = "required with `protocol`, unless `address` is given",
                              .help = "With `protocol`: serial port that is read",
                              .example = "\"/dev/ttyAMA3\""}),
    row<&PortConfig::device>({.key = "address",
                              .absent = "the bytes come from `device`",
                              .help = "With `protocol`: IP address and port for UDP, one message "
                                      "or more a datagram",
                              .example = "\"127.0.0.1:5502\""}),
    Key{{.key = "public",
         .type = boolean,
         .absent = "`false`",
         .help = "With `address`: allows one outside of this machine",
         .example = "true"}},
    Key{{.key = "sender",
         .absent = "everybody",
         .help = "With `address`: IP address whose datagrams are read; those of others are dropped",
         .example = "\"127.0.0.1\""}},
    Key{{.key = "baud",
         .type = integer,
         .absent = "that of the protocol",
         .least = 9600,
         .most = 5250000,
         .unit = "baud",
         .help = "With `device`: bit rate of the line",
         .example = "115200"}},
    row<&ByteValueSource::key>(
        {.key = "key",
         .absent = "no signature is looked at",
         .help = "With `mavlink-telemetry`: key file of the signatures; only what is signed with "
                 "this key counts",
         .example = "\"/etc/tribus/keys/drone.key\""}),
    Key{structure("signals", "Own names for values of the message: `{ name = signal }`",
                  "{ voltage = \"Voltage\" }", "the names of the message"),
        KeyKind::texts},
    row<&ValueMessageConfig::timeout>(
        {.key = "timeout",
         .absent = "three cycles of the message, 1s if the DBC file has no cycle; with "
                   "`dronecan` and `protocol` 3s",
         .least = 0.001,
         .most = 3600,
         .help = "A value that was not renewed for this long is stale",
         .example = "\"1500ms\""}),
};

}  // namespace tribus::key_rows
