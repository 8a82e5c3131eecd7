#pragma once

#include "config/draft.h"
#include "config/mistakes.h"

namespace tribus {

/// On one CAN interface every id has one sender: outputs may not share ids, and an input may not
/// listen to what an output of the same configuration sends there.
void check_can_ids(const Draft& draft, Mistakes& mistakes);

}  // namespace tribus
