#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The program `tribus`, with all its commands.
Program tribus_program();

}  // namespace tribus
