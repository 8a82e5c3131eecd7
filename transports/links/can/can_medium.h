#pragma once

#include "transports/links/medium.h"

namespace tribus {

inline constexpr Setting kInterfaceSetting{.key = "interface",
                                           .required = true,
                                           .help = "CAN interface, such as \"can0\"",
                                           .example = "\"can0\""};

/// Network interfaces of SocketCAN.
extern const Medium kCanMedium;

}  // namespace tribus
