#pragma once

#include "app/command.h"

namespace tribus {

/// The subcommand `reload`.
Command reload_command();

}  // namespace tribus
