#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/cli/command.h"
#include "config/language/mistakes.h"
#include "config/schema/schema.h"

namespace tribus {

/// The argument of a command that loads a configuration file.
CommandOption configuration_option(std::string& path);

/// Loads a configuration file; prints its mistakes to standard error and returns nothing if it has
/// any.
std::optional<Configuration> load_or_explain(const std::string& path);

/// Prints mistakes to standard error, a line for each.
void explain_mistakes(const std::vector<Mistake>& mistakes);

}  // namespace tribus
