#pragma once

#include <optional>

#include "config/read/table.h"
#include "config/schema/schema.h"

namespace tribus {

/// Reads [recorder]. `nullopt` if there is none.
std::optional<RecorderConfig> read_recorder(const Entry* entry, Reading reading);

}  // namespace tribus
