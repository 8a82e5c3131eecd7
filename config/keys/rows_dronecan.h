#pragma once

#include <array>

#include "config/keys/rows_ports.h"
#include "transports/codecs/dronecan/dronecan.h"

/// Rows of nodes of DroneCAN.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array kDroneCanKeys{
    kInterfaceKey,
    row<&DroneCanConfig::node_id>(
        {.key = "node_id",
         .absent = "the `node_id` of an output on the interface",
         .least = 1,
         .most = kMostOwnDroneCanNodeId,
         .help = "Node id of this program on the interface; 126 and 127 are for tools. Required "
                 "here or in an output, unless `dynamic` is true",
         .example = "42"}),
    row<&DroneCanConfig::dynamic>(
        {.key = "dynamic",
         .help = "`true`: asks an allocator on the bus for a node id; `node_id` is then the one "
                 "that it prefers. For RC into an autopilot use a fixed id: autopilots take RC "
                 "from the id that they heard first",
         .example = "true"}),
    row<&DroneCanConfig::node_name>(
        {.key = "name",
         .help = "Name of the node that others see: small letters, digits, `.`, `_` and `-`",
         .example = "\"org.example.rover\""}),
    row<&DroneCanConfig::allow_restart>({.key = "allow_restart",
                                         .help = "`true`: other nodes may restart this program",
                                         .example = "true"}),
    row<&DroneCanConfig::allow_writes>(
        {.key = "allow_writes",
         .help = "`true`: other nodes may write parameters: the periods of outputs, until the "
                 "next start",
         .example = "true"}),
};

}  // namespace tribus::key_rows
