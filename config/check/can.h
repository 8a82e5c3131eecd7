#pragma once

#include "config/language/mistakes.h"
#include "config/read/draft.h"

namespace tribus {

/// On a CAN interface each id has one sender: two outputs must not share an id, and an input must
/// not receive an id that an output of the same configuration sends.
void check_can_ids(const Draft& draft, Mistakes& mistakes);

}  // namespace tribus
