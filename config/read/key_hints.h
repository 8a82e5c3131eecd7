#pragma once

#include <optional>
#include <span>
#include <string>

#include "config/read/table.h"

namespace tribus {

/// What to do about a key that people expect in a table although it does not have it: a rate, a
/// parity, a number of channels. `nullopt` for other keys.
std::optional<std::string> hint_for_key(const Entry& entry, const TableRef& ref,
                                        std::span<const Key> keys);

}  // namespace tribus
