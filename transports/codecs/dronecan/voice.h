#pragma once

#include "transports/codecs/dronecan/transfer.h"

namespace tribus::dronecan {

/// What the node of an interface lets those say who send in its name.
struct Voice {
    /// kNobody while it has no id, or another node has the same one: then nothing is to be said.
    NodeId id = kNobody;
};

}  // namespace tribus::dronecan
