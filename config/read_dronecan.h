#pragma once

#include "config/draft.h"
#include "config/read_table.h"

namespace tribus {

/// Reads [dronecan.NAME].
DroneCanDraft read_dronecan(const Entry& entry, const Table& table, Reading reading);

/// Checks DroneCAN nodes and outputs against each other: outputs without an id, several ids on one
/// interface, messages that two outputs send.
void check_dronecan(const Draft& draft, Mistakes& mistakes);

}  // namespace tribus
