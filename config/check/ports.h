#pragma once

#include "config/language/mistakes.h"
#include "config/read/draft.h"

namespace tribus {

/// Warns of paths that depend on the working folder, of one port under two names, and of outputs
/// whose frames come back to an input of the same file. Looks at the file system, but opens
/// nothing.
void doubt_ports(const Draft& draft, Mistakes& warnings);

}  // namespace tribus
