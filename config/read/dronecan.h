#pragma once

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// Reads [dronecan.NAME].
DroneCanDraft read_dronecan(const Entry& entry, const Table& table, Reading reading);

}  // namespace tribus
