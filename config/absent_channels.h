#pragma once

#include <vector>

#include "config/mistakes.h"
#include "config/schema.h"

namespace tribus {

/// What is allowed and may surprise: each channel that a map makes of one which its input's
/// protocol does not have for certain. By line and column.
std::vector<Mistake> maps_of_absent_channels(const Configuration& configuration);

}  // namespace tribus
