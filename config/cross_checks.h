#pragma once

#include "config/draft.h"
#include "config/read_table.h"

namespace tribus {

/// What only shows when all tables are read: devices used twice, inputs and outputs that nothing
/// uses, timeouts that no output period fits in, no pipeline at all.
void check_across(const Draft& draft, Reading reading);

}  // namespace tribus
