#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "config/keys/keys.h"

namespace tribus {

/// Writes an object as TOML: a header for each table that has one in the key table, everything else
/// in one line each.
std::string write_toml(const nlohmann::ordered_json& json, std::span<const Key> keys);

}  // namespace tribus
