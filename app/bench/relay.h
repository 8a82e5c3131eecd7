#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tribus::bench {

/// The least that carries bytes from one device to another: wait, read, write, and nothing else.
/// What every figure of the appliance is held against.
struct RelaySettings {
    enum class Waits : std::uint8_t { poll, epoll };
    Waits waits = Waits::poll;
    std::optional<int> priority;  ///< SCHED_FIFO, with memory locked; else as any program
    std::optional<int> cpu;
};

/// Carries from the first device of each pair to the second. Does not return; the exit status of
/// the process tells what could not be done, in words on standard error. Allocates before it has
/// opened its devices only.
int run_relay(const std::vector<std::pair<std::string, std::string>>& devices,
              const RelaySettings& settings);

}  // namespace tribus::bench
