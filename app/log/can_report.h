#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "app/appliance/appliance.h"
#include "app/journal/log_limit.h"
#include "core/rate_limit.h"
#include "core/time.h"

namespace tribus {

/// Logs about the CAN interfaces: at the start their configuration, with advice, and later what was
/// lost and what was restarted. Thread-bound to the main thread.
class CanReport {
  public:
    explicit CanReport(const Appliance& appliance);

    /// Logs the configuration of each interface.
    void start(const Appliance& appliance);
    /// After a reload: takes over what `before` knows about the interfaces that are still used.
    void go_on_from(const CanReport& before, const Appliance& appliance);
    /// Logs losses since the last call, and the restarts meanwhile. Call it a few times a second.
    void look(const Appliance& appliance, std::span<const BusOffWatch::Restart> restarts,
              Instant now);

  private:
    struct Memory {
        std::size_t port = 0;
        std::uint64_t receive_overflows = 0;
        RateLimit limit = log_limit();
        RateLimit overflow_limit = log_limit();
    };

    void look_at_overflows(const std::string& name, const CanLinkStatus& status, Memory& memory,
                           Instant now);

    std::map<std::string, Memory> interfaces_;
};

}  // namespace tribus
