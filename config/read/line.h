#pragma once

#include <string_view>

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// Reads one [gpio.NAME]. The draft must have all inputs and outputs.
LineDraft read_line(const Entry& entry, const Table& table, const Draft& draft, Reading reading);

/// Whether a line with that role can have the key.
bool role_has(LineRole role, std::string_view key);

}  // namespace tribus
