#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The subcommand `monitor`: a live view of a running daemon.
Command monitor_command();

}  // namespace tribus
