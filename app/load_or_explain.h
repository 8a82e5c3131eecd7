#pragma once

#include <optional>
#include <string>

#include "config/schema.h"

namespace tribus {

/// Loads a configuration file; prints all its mistakes to standard error if it has any.
std::optional<Configuration> load_or_explain(const std::string& path);

}  // namespace tribus
