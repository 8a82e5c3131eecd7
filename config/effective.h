#pragma once

#include <string>

#include "config/schema.h"

namespace tribus {

/// A configuration with every default filled in, in the order of the key table. The TOML is valid
/// input again and means the same; a map of a channel without any shaping is written short.
std::string effective_toml(const Configuration& configuration);
/// The same as one JSON object, indented; durations as in TOML, channels as text keys.
std::string effective_json(const Configuration& configuration);

}  // namespace tribus
