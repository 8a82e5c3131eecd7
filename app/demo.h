#pragma once

#include "app/command.h"

namespace tribus {

/// The subcommand `demo`: the main job with nothing attached, over real ttys.
Command demo_command();

}  // namespace tribus
