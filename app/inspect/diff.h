#pragma once

#include <string>

#include "app/cli/command.h"
#include "config/schema/schema.h"

namespace tribus {

/// Differences between two configurations, one line each: changed settings, changed channels, and
/// what a reload does with them. Empty if nothing changes. Pure.
std::string configuration_difference(const Configuration& running, const Configuration& fresh);

/// The subcommand `diff`.
Command diff_command();

}  // namespace tribus
