#pragma once

#include <cstdint>

#include "transports/codecs/protocol.h"

namespace tribus {

/// DroneCAN (UAVCAN v0): docs/protocols/can.md.
extern const Protocol kDroneCanProtocol;

/// The highest id that this program may have on a bus: 126 and 127 are for tools.
inline constexpr std::uint8_t kMostOwnDroneCanNodeId = 125;

}  // namespace tribus
