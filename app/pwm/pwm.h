#pragma once

#include <filesystem>
#include <string>

#include "app/cli/command.h"
#include "transports/links/pwm/pwm_chip.h"

namespace tribus {

/// The subcommand `pwm`: the PWM chips of this machine and what their outputs do; or switches the
/// outputs of a configuration off.
Command pwm_command();

/// The chips below `root` and their outputs in use, a line each. May block.
std::string pwm_report(const std::filesystem::path& root = "/");

}  // namespace tribus
