#pragma once

#include <string>

#include "config/schema.h"

namespace CLI {
class App;
}

namespace tribus {

/// What changes where `fresh` takes the place of `running`, in words and line by line: what is set
/// otherwise, channel by channel, and what that means for whoever uses it. Empty where nothing
/// changes. Pure.
std::string configuration_difference(const Configuration& running, const Configuration& fresh);

/// The subcommand `diff`.
void add_diff_command(CLI::App& app, int& status);

}  // namespace tribus
