#pragma once

#include <string>

#include "app/cli/command.h"

namespace tribus::web {

/// The program `tribus-web`, with all its commands.
Program web_program(std::string version);

}  // namespace tribus::web
