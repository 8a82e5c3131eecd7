#pragma once

#include <optional>

#include "config/read_table.h"
#include "config/schema.h"

namespace tribus {

/// [recorder]; nothing where it is not there.
std::optional<RecorderConfig> read_recorder(const Entry* entry, Reading reading);

}  // namespace tribus
