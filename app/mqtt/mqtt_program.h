#pragma once

#include <string>

#include "app/cli/command.h"

namespace tribus::mqtt {

/// The program `tribus-mqtt`, with its command.
Program mqtt_program(std::string version);

}  // namespace tribus::mqtt
