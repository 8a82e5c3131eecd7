#pragma once

#include <optional>
#include <string_view>

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// Reads one [gpio.NAME]. The draft must have all inputs and outputs.
LineDraft read_line(const Entry& entry, const Table& table, const Draft& draft, Reading reading);

/// The line of the freshness wave that a key of the output names (Medium::enable_key), if there is
/// one. Its task lacks the output. `where`: place of the value.
std::optional<LineDraft> read_enable_line(const OutputConfig& output, Location where,
                                          Mistakes& mistakes);

/// Whether a line with that role can have the key.
bool role_has(LineRole role, std::string_view key);

}  // namespace tribus
