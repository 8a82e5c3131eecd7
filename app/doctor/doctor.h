#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The subcommand `doctor`: checks ports and machine, and says what to fix.
Command doctor_command();

}  // namespace tribus
