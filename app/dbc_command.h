#pragma once

#include "app/command.h"

/// The subcommand `dbc`: the native CAN format as a DBC file, for other tools on the bus.
namespace tribus {

Command dbc_command();

}  // namespace tribus
