#pragma once

#include "transports/codecs/protocol.h"

namespace tribus {

/// DroneCAN (UAVCAN v0): can.md section 1.
extern const Protocol kDroneCanProtocol;

}  // namespace tribus
