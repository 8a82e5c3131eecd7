#pragma once

#include <span>
#include <string_view>

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// Reads one [gpio.NAME]. The draft must have all inputs and outputs.
LineDraft read_line(const Entry& entry, const Table& table, const Draft& draft, Reading reading);

/// The keys of a line with that role.
std::span<const std::string_view> keys_of_role(LineRole role);

/// The name of a role in the configuration.
std::string_view name_of(LineRole role);

}  // namespace tribus
