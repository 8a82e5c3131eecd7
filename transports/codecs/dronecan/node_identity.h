#pragma once

#include "transports/codecs/dronecan/transfer.h"

namespace tribus::dronecan {

/// The node that outputs of an interface send as.
struct NodeIdentity {
    /// kNobody while the node has no id, or another node has the same one: nothing may be sent
    /// then.
    NodeId id = kNobody;
};

}  // namespace tribus::dronecan
