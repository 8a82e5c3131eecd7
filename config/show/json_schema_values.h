#pragma once

#include <nlohmann/json_fwd.hpp>

#include "config/keys/keys.h"

namespace tribus {

/// JSON schema of a row of the kind `value`, with its default.
nlohmann::ordered_json value_schema(const Key& key);

}  // namespace tribus
