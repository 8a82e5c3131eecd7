#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/setting.h"

namespace tribus {

/// JSON schema of one row of the key table, with its default.
nlohmann::ordered_json setting_schema(const Setting& setting);

}  // namespace tribus
