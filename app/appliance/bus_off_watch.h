#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/time.h"

namespace tribus {

/// Restarts CAN interfaces after bus-off where the kernel does not: with `restart-ms` 0 a
/// controller stays off until somebody restarts it. Thread-bound to the main thread.
class BusOffWatch {
  public:
    struct Restart {
        std::string interface;
        std::string error{};  ///< a sentence; empty: it was restarted
    };

    /// `off`: whether the controller of the interface is off at `now`. Returns what was tried.
    std::optional<Restart> look(const std::string& interface, bool off, Instant now);

  private:
    /// Since when each is off, or since the last try.
    std::map<std::string, Instant> off_since_;
};

}  // namespace tribus
