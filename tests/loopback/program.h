#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <ctime>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tribus::test {

/// How long a test waits for an event before it fails: far longer than any event takes on a loaded
/// machine.
inline constexpr std::chrono::seconds kPatience{15};

/// Calls `done` every few milliseconds until it is true; false if patience ends first.
template <class Done>
bool eventually(Done done) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!done()) {
        if (std::chrono::steady_clock::now() > end) {
            return false;
        }
        const timespec pause{.tv_sec = 0, .tv_nsec = 2'000'000};
        ::nanosleep(&pause, nullptr);
    }
    return true;
}

/// Debian's account `nobody`, and its group.
inline constexpr uid_t kOrdinaryUser = 65534;

/// Whether the program runs with the heap trap; not where a sanitizer has the heap.
bool heap_trap_works();

struct ProgramSettings {
    std::string executable = TRIBUS_PROGRAM;
    /// A tty that becomes its controlling terminal, standard input and standard output.
    std::string terminal = {};
    /// As a service manager gives one; empty: the test's folder.
    std::string runtime_directory = {};
    /// An account without rights, with Debian's limits: 8 MiB of locked memory and of stack, no
    /// real-time priority. Without the heap trap. Where the tests have no root, their own account.
    bool ordinary_user = false;
    std::size_t most_locked_bytes = 8 << 20;  ///< of an ordinary user
};

/// A program at work, with the heap trap. Never outlives its object, nor the test.
class Program {
  public:
    /// Output goes to files in `folder`.
    Program(const std::filesystem::path& folder, const std::vector<std::string>& arguments,
            const ProgramSettings& settings = {});
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;
    ~Program();

    void signal(int number) const;
    bool runs();
    /// Processor time that it has used so far.
    std::chrono::nanoseconds used_time() const;
    /// How many descriptors it has open, without those of files that it opens for a moment now and
    /// then: the fewest of several looks.
    std::ptrdiff_t open_descriptors() const;
    /// A line of /proc/PID/status, such as "VmRSS", in KiB.
    long memory_kib(const std::string& line) const;
    /// Waits for its end; the exit status, or 128 and the signal that ended it.
    std::optional<int> end();

    std::string output() const;
    std::string errors() const;
    /// Waits until standard error has `text` so many times.
    bool says(const std::string& text, std::size_t times = 1) const;

  private:
    [[noreturn]] void become(const std::vector<std::string>& arguments,
                             const ProgramSettings& settings, pid_t parent) const;
    void note_end(int status);

    std::string output_file_;
    std::string errors_file_;
    pid_t pid_ = -1;
    std::optional<int> ended_;
};

/// How often `part` stands in `text`.
std::size_t count_of(const std::string& part, const std::string& text);

}  // namespace tribus::test
