#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The subcommand `reload`.
Command reload_command();

}  // namespace tribus
