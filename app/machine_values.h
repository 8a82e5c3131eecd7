#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipelines/machine_facts.h"

/// What the board tells of itself, in the files of the Linux kernel.
namespace tribus {

/// In the order of the facts; what a board does not tell is nothing.
using MachineValues = std::array<std::optional<double>, kMachineFactCount>;

/// What /etc/machine-id says; empty where there is none.
std::string machine_id(const std::filesystem::path& root = "/");

/// Looks at the machine: opens and reads a few small files, so not for the data thread, and no more
/// often than once a second or so. What a board does not tell, or tells in no number, is nothing.
/// Thread-bound.
class MachineWatch {
  public:
    /// Finds out which files there are. `root` is "/" but for tests.
    explicit MachineWatch(std::filesystem::path root = "/");

    /// `load` has no number at the first look.
    MachineValues look();

  private:
    /// Time of all processors since the start, in ticks.
    struct ProcessorTime {
        std::uint64_t all = 0;
        std::uint64_t idle = 0;
    };

    std::optional<double> temperature() const;
    std::optional<double> load();
    std::optional<double> memory() const;
    std::optional<double> supply() const;
    std::optional<double> undervoltage() const;
    std::optional<double> uptime() const;
    std::optional<ProcessorTime> processor_time() const;

    std::filesystem::path root_;
    std::vector<std::filesystem::path> zones_;
    std::vector<std::filesystem::path> supplies_;
    std::optional<std::filesystem::path> alarm_;
    std::optional<ProcessorTime> before_;
};

}  // namespace tribus
