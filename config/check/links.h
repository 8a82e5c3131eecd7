#pragma once

#include "config/language/mistakes.h"
#include "config/read/draft.h"

namespace tribus {

/// Checks that no two links of one file can be taken for each other.
void check_links(const Draft& draft, Mistakes& mistakes);

}  // namespace tribus
