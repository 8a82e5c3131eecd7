#pragma once

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// Checks GPIO lines against each other, and against outputs and pipelines.
void check_lines(const Draft& draft, Reading reading);

}  // namespace tribus
