#pragma once

#include "transports/links/medium.h"

namespace tribus {

inline constexpr Setting kDeviceSetting{
    .key = "device",
    .required = true,
    .help = "Serial device, such as \"/dev/ttyAMA5\" or a stable name under /dev/serial/by-id",
    .example = "\"/dev/ttyAMA5\""};

/// Serial ports: UARTs, USB adapters and ptys.
extern const Medium kSerialMedium;

}  // namespace tribus
