#pragma once

#include <string>

#include "app/cli/command.h"

namespace tribus::mqtt {

/// `tribus-mqtt run`: tells a broker of the daemons of this board, until a signal ends it.
Command mqtt_command(std::string version);

}  // namespace tribus::mqtt
