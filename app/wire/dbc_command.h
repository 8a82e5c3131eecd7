#pragma once

#include "app/cli/command.h"

/// The subcommand `dbc`: prints the native CAN formats as DBC files, for other tools on the bus.
namespace tribus {

Command dbc_command();

}  // namespace tribus
