#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/appliance/appliance.h"
#include "app/journal/log_limit.h"
#include "core/change_report.h"
#include "core/rate_limit.h"
#include "core/time.h"
#include "pipelines/dronecan/node.h"
#include "pipelines/engine/carry_over.h"

namespace tribus {

/// Logs changes of this program's DroneCAN nodes; logs nothing while nothing changes. Thread-bound
/// to the main thread.
class NodeLog {
  public:
    explicit NodeLog(const Appliance& appliance);

    /// After a reload: takes over what `before` knows about the nodes that go on.
    void go_on_from(const NodeLog& before, std::span<const CarriedFrom> from);
    /// Logs changes since the last call. Call it a few times a second.
    void look(const Appliance& appliance, Instant now);

  private:
    struct Word {
        dronecan::NodeStage stage = dronecan::NodeStage::online;
        dronecan::NodeId id = dronecan::kNobody;  ///< while it is online

        bool operator==(const Word&) const = default;
    };
    struct Memory {
        std::string interface;
        dronecan::NodeId wanted = dronecan::kNobody;  ///< as configured
        ChangeReport<Word> word;
        RateLimit limit = log_limit();
    };

    static void log_change(const Memory& memory, const std::string& note);

    std::vector<Memory> nodes_;
};

}  // namespace tribus
