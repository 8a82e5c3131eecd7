#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus::bench {

/// A process that a measurement needs. It ends with its object, and with the thread that started
/// it, however that ends. Thread-bound.
class Process {
  public:
    /// A copy of this process that does nothing but `body`, which allocates nothing.
    static tl::expected<Process, std::string> fork(const std::function<int()>& body);
    /// A program, the first of `words`, found as a shell would. Of the descriptors that close on
    /// exec it gets `passed` all the same. `environment` adds NAME=VALUE.
    static tl::expected<Process, std::string> execute(
        const std::vector<std::string>& words, const std::vector<int>& passed = {},
        const std::vector<std::string>& environment = {});

    Process(Process&& other) noexcept;
    Process& operator=(Process&& other) noexcept;
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;
    ~Process();

    pid_t id() const { return id_; }
    bool runs();
    /// Asks it to end, and ends it where it does not within two seconds. Returns its exit status,
    /// or 128 and the signal that ended it.
    int end();
    /// What it said to standard error so far.
    std::string errors() const;

  private:
    Process(pid_t id, UniqueFd errors);

    pid_t id_ = -1;
    UniqueFd errors_;
    std::optional<int> ended_;
};

/// What a process has used since it started, and has now.
struct ProcessUsage {
    Duration processor_time{};  ///< of all its threads that live
    std::uint64_t minor_faults = 0;
    std::uint64_t major_faults = 0;
    std::size_t resident_bytes = 0;
    std::size_t locked_bytes = 0;
};

/// Nothing where there is no such process.
std::optional<ProcessUsage> usage_of(pid_t process);

}  // namespace tribus::bench
