#pragma once

#include <span>
#include <string_view>

#include "config/draft.h"
#include "config/read_table.h"

namespace tribus {

/// One [gpio.NAME]. The inputs and outputs of the draft must be complete.
LineDraft read_line(const Entry& entry, const Table& table, const Draft& draft, Reading reading);

/// The keys that a line has because of its role.
std::span<const std::string_view> keys_of_role(LineRole role);

std::string_view name_of(LineRole role);

}  // namespace tribus
