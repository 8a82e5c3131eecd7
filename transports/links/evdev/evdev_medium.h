#pragma once

#include "transports/links/medium.h"

namespace tribus {

/// Gamepads and joysticks at /dev/input.
extern const Medium kEvdevMedium;

}  // namespace tribus
