#pragma once

#include "config/draft.h"
#include "config/read_table.h"

namespace tribus {

/// [dronecan.NAME]
DroneCanDraft read_dronecan(const Entry& entry, const Table& table, Reading reading);

/// What is wrong with nodes, inputs and outputs of DroneCAN beside each other: outputs without an
/// id, several ids on one interface, messages that two outputs send.
void check_dronecan(const Draft& draft, Mistakes& mistakes);

}  // namespace tribus
