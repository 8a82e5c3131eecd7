#pragma once

#include "transports/links/medium.h"

namespace tribus {

/// Joysticks that the kernel makes for this program (uinput).
extern const Medium kUinputMedium;

}  // namespace tribus
