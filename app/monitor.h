#pragma once

#include "app/command.h"

namespace tribus {

/// The subcommand `monitor`: what a running daemon does.
Command monitor_command();

}  // namespace tribus
