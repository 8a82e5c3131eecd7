#pragma once

#include "app/cli/command.h"

namespace tribus {

/// `tribus replay`: sends a recording with its timing to a pseudo-terminal, a serial device or a
/// CAN interface.
Command replay_command();

}  // namespace tribus
