#pragma once

#include <nlohmann/json_fwd.hpp>

#include "config/schema/schema.h"

namespace tribus {

/// [gpio.NAME] with all defaults of its role.
nlohmann::ordered_json line_json(const LineConfig& line, const Configuration& configuration);

}  // namespace tribus
