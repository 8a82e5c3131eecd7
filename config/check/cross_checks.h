#pragma once

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// Checks across tables: devices that are used twice, unused inputs and outputs, timeouts shorter
/// than a period, no pipeline.
void check_across(const Draft& draft, Reading reading);

}  // namespace tribus
