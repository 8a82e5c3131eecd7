#pragma once

#include "app/cli/command.h"

namespace tribus {

/// `tribus init`.
Command init_command();

}  // namespace tribus
