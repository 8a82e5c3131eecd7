#pragma once

#include <nlohmann/json_fwd.hpp>

#include "config/schema.h"

namespace tribus {

/// A [gpio.NAME] with every default that its role has.
nlohmann::ordered_json line_json(const LineConfig& line, const Configuration& configuration);

}  // namespace tribus
