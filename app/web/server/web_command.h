#pragma once

#include <string>

#include "app/cli/command.h"

namespace tribus::web {

/// The command `serve` of tribus-web: it serves the page until a signal ends it, or, if systemd
/// listens for it, until nobody has used it for ten minutes.
Command web_command(std::string version);

}  // namespace tribus::web
