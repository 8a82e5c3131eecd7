#pragma once

#include <string>
#include <vector>

#include "app/appliance.h"
#include "core/rate_limit.h"
#include "core/time.h"
#include "pipelines/dronecan/node.h"

namespace tribus {

/// Says what changed with this program's nodes of DroneCAN, and nothing while nothing does.
/// Thread-bound to the main thread.
class NodeLog {
  public:
    explicit NodeLog(const Appliance& appliance);

    void look(const Appliance& appliance, Instant now);

  private:
    struct Memory {
        std::string interface;
        dronecan::NodeId wanted = dronecan::kNobody;  ///< that the configuration gives
        bool dynamic = false;
        dronecan::NodeStage stage = dronecan::NodeStage::online;
        dronecan::NodeId id = dronecan::kNobody;
        RateLimit limit;
    };

    static void say_change(const Memory& memory, const std::string& note);

    std::vector<Memory> nodes_;
};

}  // namespace tribus
