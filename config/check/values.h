#pragma once

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// Checks named values across tables: unknown names, units that do not convert, names that are used
/// twice.
void check_values(const Draft& draft, Reading reading);

}  // namespace tribus
