#pragma once

#include <array>
#include <string_view>

#include "config/key_rows_ports.h"
#include "transports/codecs/dronecan/value_reader.h"
#include "transports/codecs/ibus_sensor_types.h"

/// Rows of sensor buses, their types, and named values.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array<std::string_view, 2> kBusRoleChoices{"sensor", "receiver"};
/// In the order of `Wires`.
inline constexpr std::array<std::string_view, 3> kWiresChoices{"auto", "one", "two"};
inline constexpr std::array kSensorKeys{
    Key{{.key = "type",
         .type = text,
         .required = true,
         .help = "What the receiver shows, such as \"external_voltage\""}},
    Key{{.key = "value",
         .type = text,
         .help = "The named value that is sent, such as \"battery.voltage\""}},
    Key{structure("values", "The same for a type with several fields: { field = value }"),
        KeyKind::texts},
    Key{{.key = "scale",
         .type = number,
         .help = "The value is multiplied by it, to be in the unit of the type; absent: the units "
                 "of both tell"}},
    Key{{.key = "offset", .type = number, .fallback = "0", .help = "Added after that"}},
    Key{{.key = "not_available",
         .type = number,
         .help = "Sent while there is no fresh value, where the type has no code for that; "
                 "absent: the sensor does not answer then"}},
};

inline constexpr std::array kSensorBusKeys{
    kDeviceKey,
    Key{{.key = "role",
         .type = choice,
         .required = true,
         .choices = kBusRoleChoices,
         .help = "sensor: answers a receiver as the sensors of the list; receiver: finds and "
                 "polls sensors"}},
    Key{{.key = "wires",
         .type = choice,
         .fallback = "\"auto\"",
         .choices = kWiresChoices,
         .help = "one: a single wire for both directions, on which the port hears itself; two: a "
                 "wire for each; auto: finds out"}},
    Key{{.key = "dialect",
         .type = choice,
         .fallback = "\"flysky\"",
         .choices = kSensorDialectNames,
         .help = "Whose meaning of the sensor types that are disputed"}},
    Key{structure("sensor", "Role sensor: the sensors, in the order of their addresses"),
        KeyKind::list, kSensorKeys},
    Key{{.key = "address",
         .type = integer,
         .fallback = "1",
         .least = 1,
         .most = 15,
         .help = "Role sensor: address of the first sensor, the others follow"}},
    Key{{.key = "chain",
         .type = boolean,
         .fallback = "false",
         .help = "Role sensor: behind genuine sensors in a daisy chain; the first sensor takes the "
                 "address of the first discover request that comes, instead of `address`"}},
    Key{{.key = "reply_after",
         .type = duration,
         .fallback = "\"200us\"",
         .least = 0,
         .most = 0.002,
         .help = "Role sensor: an answer leaves so long after its request was read"}},
    Key{{.key = "reply_within",
         .type = duration,
         .fallback = "\"1ms\"",
         .least = 0.0002,
         .most = 0.003,
         .help = "Role sensor: an answer that would leave later is withheld"}},
    Key{{.key = "slot",
         .type = duration,
         .fallback = "\"7.7ms\"",
         .least = 0.0035,
         .most = 0.1,
         .help = "Role receiver: one request each"}},
    Key{{.key = "power_up",
         .type = boolean,
         .fallback = "true",
         .help = "Role receiver: begins with the power-up frames of genuine receivers"}},
    Key{{.key = "probe_every",
         .type = integer,
         .fallback = "66",
         .least = 2,
         .most = 10000,
         .help = "Role receiver: one slot of so many looks for a further sensor"}},
    Key{{.key = "drop_after",
         .type = integer,
         .fallback = "66",
         .least = 1,
         .most = 10000,
         .help = "Role receiver: after so many requests in a row without an answer a sensor is "
                 "gone"}},
    Key{{.key = "timeout",
         .type = duration,
         .fallback = "\"2s\"",
         .least = 0.01,
         .most = 60,
         .help = "Role receiver: a value that was not renewed for so long is stale"}},
};

inline constexpr std::array kSensorTypeKeys{
    Key{{.key = "id",
         .type = integer,
         .required = true,
         .least = 1,
         .most = 254,
         .help = "The number of the type on the wire"}},
    Key{{.key = "size",
         .type = integer,
         .fallback = "2",
         .least = 1,
         .most = 4,
         .help = "Bytes of its value"}},
    Key{{.key = "signed", .type = boolean, .fallback = "false", .help = "Two's complement"}},
    Key{{.key = "scale", .type = number, .fallback = "1", .help = "number = raw * scale + offset"}},
    Key{{.key = "offset", .type = number, .fallback = "0", .help = "See scale"}},
    Key{{.key = "unit", .type = text, .help = "Of the number, such as \"V\""}},
    Key{{.key = "not_available",
         .type = integer,
         .least = -2147483648.0,
         .most = 4294967295.0,
         .help = "The raw value that says that there is none"}},
};

inline constexpr std::array kValuesKeys{
    Key{{.key = "constant",
         .type = number,
         .help = "A number that does not change; instead of a message"}},
    Key{{.key = "unit", .type = text, .help = "Of the constant, such as \"V\""}},
    Key{{.key = "interface",
         .type = text,
         .help = "CAN interface that the message comes from, such as \"can0\""}},
    Key{{.key = "dbc",
         .type = file,
         .help = "The DBC file that describes the message, from the folder of this file"}},
    Key{{.key = "message",
         .type = text,
         .help = "Its name in that file; each of its signals is a value, NAME.SIGNAL"}},
    Key{{.key = "dronecan",
         .type = choice,
         .choices = dronecan::kValueMessages,
         .help = "Instead of a DBC file: the message of DroneCAN; each of its numbers is a value, "
                 "NAME.FIELD"}},
    Key{{.key = "node",
         .type = integer,
         .least = 1,
         .most = dronecan::kMostNodeId,
         .help = "The DroneCAN node that is listened to; absent: the first one that is heard"}},
    Key{{.key = "instance",
         .type = integer,
         .most = 65535,
         .help = "Which one of several on the node: its battery_id, circuit_id, esc_index, "
                 "device_id, fuel_tank_id or sensor_id; absent: the first one that is heard"}},
    Key{{.key = "fd",
         .type = boolean,
         .help = "DroneCAN: frames of CAN FD are read too; absent: false"}},
    Key{structure("signals", "Own names for values of the message: { name = signal }"),
        KeyKind::texts},
    Key{{.key = "timeout",
         .type = duration,
         .least = 0.001,
         .most = 3600,
         .help = "A value that was not renewed for so long is stale; the default is three cycles "
                 "of the message, or 1s where the file does not tell its cycle; of DroneCAN 3s"}},
};

}  // namespace tribus::key_rows
