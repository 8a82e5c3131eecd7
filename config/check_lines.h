#pragma once

#include "config/draft.h"
#include "config/read_table.h"

namespace tribus {

/// Checks GPIO lines against each other, and against outputs and pipelines.
void check_lines(const Draft& draft, Reading reading);

}  // namespace tribus
