#pragma once

#include "app/command.h"

namespace tribus {

/// `tribus replay`: a recording into a pseudo-terminal, a serial device or a CAN interface, with
/// its timing.
Command replay_command();

}  // namespace tribus
