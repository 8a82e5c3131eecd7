#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "config/schema/schema.h"

namespace tribus {

/// Upper limit of the parts of a key, `a.b.c`. The TOML library accepts any number, nests that many
/// tables, and needs as much stack to destroy them. No key of a configuration has more than a few.
inline constexpr std::size_t kMostKeyParts = 16;

/// Place of the first key or header with too many parts. Ignores strings and comments. Accepts any
/// bytes. Pure.
std::optional<Location> find_key_of_too_many_parts(std::string_view text);

}  // namespace tribus
