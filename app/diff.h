#pragma once

#include <string>

#include "app/command.h"
#include "config/schema.h"

namespace tribus {

/// What changes where `fresh` takes the place of `running`, in words and line by line: what is set
/// otherwise, channel by channel, and what that means for whoever uses it. Empty where nothing
/// changes. Pure.
std::string configuration_difference(const Configuration& running, const Configuration& fresh);

/// The subcommand `diff`.
Command diff_command();

}  // namespace tribus
