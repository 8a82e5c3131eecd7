#pragma once

#include "app/cli/command.h"

namespace tribus::web {

/// The subcommand `pair`: a code with which a browser may use the page.
Command pair_command();

}  // namespace tribus::web
