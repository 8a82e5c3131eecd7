#pragma once

#include <string>

#include "config/schema/schema.h"

namespace tribus {

/// The configuration as TOML with every default, in the order of the key table. It is a valid
/// configuration with the same meaning. A channel that is only mapped is written in the short form.
std::string effective_toml(const Configuration& configuration);
/// The same as an indented JSON object. Durations are written as in TOML, channel numbers are text
/// keys.
std::string effective_json(const Configuration& configuration);

}  // namespace tribus
