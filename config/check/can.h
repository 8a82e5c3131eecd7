#pragma once

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// On a CAN interface each id has one sender: two outputs must not share an id, and an input must
/// not receive an id that an output of the same configuration sends. Warns of values from messages
/// that an output sends.
void check_can_ids(const Draft& draft, Reading reading);

}  // namespace tribus
