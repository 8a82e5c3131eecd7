#pragma once

#include "config/language/mistakes.h"
#include "config/read/draft.h"

namespace tribus {

/// Checks that no two links of one file can be taken for each other, and that those which leave the
/// machine have a key if their protocol knows one.
void check_links(const Draft& draft, Mistakes& mistakes);

}  // namespace tribus
