#pragma once

#include <vector>

#include "config/language/mistakes.h"
#include "config/schema/schema.h"

namespace tribus {

/// All that an accepted configuration probably does not mean: its own warnings, and maps of
/// channels that may be absent. Sorted by line and column.
std::vector<Mistake> warnings_about(const Configuration& configuration);

}  // namespace tribus
