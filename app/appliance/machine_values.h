#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipelines/engine/machine_facts.h"

/// Measurements of this machine, from files of the Linux kernel.
namespace tribus {

/// In the order of `kMachineFacts`; empty if the board does not provide the value.
using MachineValues = std::array<std::optional<double>, kMachineFactCount>;

/// Content of /etc/machine-id; empty if there is none.
std::string machine_id(const std::filesystem::path& root = "/");

/// Reads the measurements of this machine from a few small files. Too slow for the data thread;
/// call it at most about once a second. Values that are missing or not numbers are empty.
/// Thread-bound.
class MachineWatch {
  public:
    /// Finds the files. `root` is "/" except in tests.
    explicit MachineWatch(std::filesystem::path root = "/");

    /// Reads all values. The first call returns no `load`.
    MachineValues look();

  private:
    /// Time of all processors since boot, in ticks.
    struct ProcessorTime {
        std::uint64_t all = 0;
        std::uint64_t idle = 0;
    };

    /// degC of the hottest zone.
    std::optional<double> temperature() const;
    /// Percent of processor time since the last call.
    std::optional<double> load();
    /// Percent of memory in use.
    std::optional<double> memory() const;
    /// Highest supply voltage in V.
    std::optional<double> supply() const;
    /// 1 while a Raspberry Pi reports undervoltage, else 0.
    std::optional<double> undervoltage() const;
    /// Seconds since boot.
    std::optional<double> uptime() const;
    std::optional<ProcessorTime> processor_time() const;

    std::filesystem::path root_;
    std::vector<std::filesystem::path> zones_;
    std::vector<std::filesystem::path> supplies_;
    std::optional<std::filesystem::path> alarm_;
    std::optional<ProcessorTime> before_;
};

}  // namespace tribus
