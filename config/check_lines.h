#pragma once

#include "config/draft.h"
#include "config/read_table.h"

namespace tribus {

/// What is wrong with GPIO lines beside each other, and beside outputs and pipelines.
void check_lines(const Draft& draft, Reading reading);

}  // namespace tribus
