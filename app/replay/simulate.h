#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The subcommand `simulate`: runs a configuration over recorded inputs, in virtual time.
Command simulate_command();

}  // namespace tribus
