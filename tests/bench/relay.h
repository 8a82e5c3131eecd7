#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/time.h"

namespace tribus::bench {

/// The minimum that carries bytes from one device to another: wait, read, write. All figures of
/// tribus are compared with it.
struct RelaySettings {
    enum class Waits : std::uint8_t { poll, epoll };
    Waits waits = Waits::poll;
    std::optional<int> priority;  ///< SCHED_FIFO with locked memory; else as an ordinary program
    std::optional<int> cpu;
    /// It also wakes after this time without bytes, as a program with a failsafe must.
    std::optional<Duration> timeout{};
};

/// Carries bytes from the first device of each pair to the second. Returns only on an error, with
/// an exit status and a message on standard error. Allocates only before its devices are open.
int run_relay(const std::vector<std::pair<std::string, std::string>>& devices,
              const RelaySettings& settings);

}  // namespace tribus::bench
