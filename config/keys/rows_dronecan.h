#pragma once

#include <array>

#include "config/keys/rows_ports.h"
#include "transports/codecs/dronecan/dronecan.h"

/// Rows of nodes of DroneCAN.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array kDroneCanKeys{
    kInterfaceKey,
    Key{{.key = "node_id",
         .type = integer,
         .absent = "the `node_id` of an output on the interface",
         .least = 1,
         .most = kMostOwnDroneCanNodeId,
         .help = "Node id of this program on the interface; 126 and 127 are for tools. Required "
                 "here or in an output, unless `dynamic` is true",
         .example = "42"}},
    Key{{.key = "dynamic",
         .type = boolean,
         .fallback = "false",
         .help = "`true`: asks an allocator on the bus for a node id; `node_id` is then the one "
                 "that it prefers. For RC into an autopilot use a fixed id: autopilots take RC "
                 "from the id that they heard first",
         .example = "true"}},
    Key{{.key = "name",
         .type = text,
         .fallback = "\"org.tribus\"",
         .help = "Name of the node that others see: small letters, digits, `.`, `_` and `-`",
         .example = "\"org.example.rover\""}},
    Key{{.key = "allow_restart",
         .type = boolean,
         .fallback = "false",
         .help = "`true`: other nodes may restart this program",
         .example = "true"}},
    Key{{.key = "allow_writes",
         .type = boolean,
         .fallback = "false",
         .help = "`true`: other nodes may write parameters: the periods of outputs, until the "
                 "next start",
         .example = "true"}},
};

}  // namespace tribus::key_rows
