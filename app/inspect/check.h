#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The subcommands `check` (validates a configuration) and `schema` (prints its JSON schema).
Command check_command();
Command schema_command();

}  // namespace tribus
