#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The subcommand `graph`: prints a configuration as a picture.
Command graph_command();

}  // namespace tribus
