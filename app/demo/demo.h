#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The subcommand `demo`: i.Bus to SBUS without hardware, over real ttys.
Command demo_command();

}  // namespace tribus
