#pragma once

#include <array>

#include "config/key_rows_ports.h"
#include "transports/codecs/dronecan/dronecan.h"

/// Rows of nodes of DroneCAN.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array kDroneCanKeys{
    kInterfaceKey,
    Key{{.key = "node_id",
         .type = integer,
         .least = 1,
         .most = kMostOwnDroneCanNodeId,
         .help = "126 and 127 are for tools. An output of the interface may say it instead"}},
    Key{{.key = "dynamic",
         .type = boolean,
         .fallback = "false",
         .help = "Asks an allocator on the bus for an id; node_id is the one that it would like. "
                 "Autopilots take RC from the id that they heard first, so a fixed one is better "
                 "for that"}},
    Key{{.key = "name",
         .type = text,
         .fallback = "\"org.tribus\"",
         .help = "What others see: small letters, digits, \".\", \"_\" and \"-\""}},
    Key{{.key = "allow_restart",
         .type = boolean,
         .fallback = "false",
         .help = "Others may restart this program"}},
    Key{{.key = "allow_writes",
         .type = boolean,
         .fallback = "false",
         .help = "Others may write parameters: the periods of outputs, until the next start"}},
};

}  // namespace tribus::key_rows
