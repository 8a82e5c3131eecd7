#pragma once

#include "config/language/mistakes.h"
#include "config/read/draft.h"

namespace tribus {

/// Checks DroneCAN nodes and outputs against each other: outputs without an id, several ids on one
/// interface, messages that two outputs send.
void check_dronecan(const Draft& draft, Mistakes& mistakes);

}  // namespace tribus
