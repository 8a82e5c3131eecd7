#pragma once

#include <cstdint>

#include "transports/codecs/protocol.h"

namespace tribus {

/// DroneCAN (UAVCAN v0), see docs/protocols/can.md.
extern const Protocol kDroneCanProtocol;

/// Highest node id that this program may use. 126 and 127 are for tools (docs/protocols/can.md,
/// "DroneCAN: nodes").
inline constexpr std::uint8_t kMostOwnDroneCanNodeId = 125;

}  // namespace tribus
