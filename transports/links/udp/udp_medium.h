#pragma once

#include "transports/links/medium.h"

namespace tribus {

/// UDP, one frame a datagram, on this machine unless `public` allows more.
extern const Medium kUdpMedium;

}  // namespace tribus
