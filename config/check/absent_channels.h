#pragma once

#include <vector>

#include "config/language/mistakes.h"
#include "config/schema/schema.h"

namespace tribus {

/// Notes on channels that a map makes from a channel which the input's protocol may lack. That is
/// allowed, but may surprise. Sorted by line and column.
std::vector<Mistake> maps_of_absent_channels(const Configuration& configuration);

}  // namespace tribus
