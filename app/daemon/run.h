#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The subcommand `run`: the daemon, in the foreground.
Command run_command();

}  // namespace tribus
