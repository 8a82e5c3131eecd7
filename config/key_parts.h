#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "config/schema.h"

namespace tribus {

/// The TOML library takes a key of any number of parts, `a.b.c`, makes as many tables, each in the
/// one before, and needs a stack that is as deep to let go of them. No key of a configuration has
/// more than a few.
inline constexpr std::size_t kMostKeyParts = 16;

/// Where the first part too many of a key or a header stands. Texts and comments are passed over.
/// Any bytes are allowed. Pure.
std::optional<Location> find_key_of_too_many_parts(std::string_view text);

}  // namespace tribus
