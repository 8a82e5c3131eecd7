#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/setting.h"

namespace tribus {

/// What one row of the key table allows, as a JSON schema, with its default.
nlohmann::ordered_json setting_schema(const Setting& setting);

}  // namespace tribus
