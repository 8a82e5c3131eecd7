#pragma once

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus::bench {

/// A process used by a measurement. It ends with its object, and with the thread that started it.
/// Thread-bound.
class Process {
  public:
    /// A copy of this process that only runs `body`, which must not allocate.
    static tl::expected<Process, std::string> fork(const std::function<int()>& body);
    /// Runs a program; `words` is its command line, and its first word is looked up in $PATH. The
    /// program inherits the descriptors `passed` although they close on exec. `environment` adds
    /// NAME=VALUE. The error is a sentence.
    static tl::expected<Process, std::string> execute(
        const std::vector<std::string>& words, const std::vector<int>& passed = {},
        const std::vector<std::string>& environment = {});

    Process(Process&& other) noexcept;
    Process& operator=(Process&& other) noexcept;
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;
    ~Process();

    pid_t id() const { return id_; }
    /// False once the process has ended.
    bool runs();
    /// Terminates the process, after two seconds by SIGKILL. Returns its exit status, or 128 plus
    /// the signal that ended it.
    int end();
    /// Its standard error so far.
    std::string errors() const;

  private:
    Process(pid_t id, UniqueFd errors);

    pid_t id_ = -1;
    UniqueFd errors_;
    std::optional<int> ended_;
};

/// Returns the text of a file of /proc; empty if there is none.
std::string content_of(const std::filesystem::path& path);

/// Resources of a process: some since its start, some at present.
struct ProcessUsage {
    Duration processor_time{};  ///< of all its living threads
    std::size_t resident_bytes = 0;
    std::size_t anonymous_bytes = 0;  ///< of the resident ones those that are of no file
    std::size_t locked_bytes = 0;
};

/// Nothing if there is no such process.
std::optional<ProcessUsage> usage_of(pid_t process);

}  // namespace tribus::bench
