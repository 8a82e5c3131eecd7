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

/// Time that a test waits for an event before it fails. It is far longer than any event takes on a
/// busy machine.
inline constexpr std::chrono::seconds kPatience{60};

/// Calls `done` every few milliseconds until it returns true. Returns false when patience is over.
template <class Done>
bool eventually(Done done, std::chrono::seconds patience = kPatience) {
    const auto end = std::chrono::steady_clock::now() + patience;
    while (!done()) {
        if (std::chrono::steady_clock::now() > end) {
            return false;
        }
        const timespec pause{.tv_sec = 0, .tv_nsec = 2'000'000};
        ::nanosleep(&pause, nullptr);
    }
    return true;
}

/// Debian's account `nobody` and its group.
inline constexpr uid_t kOrdinaryUser = 65534;

struct ProgramSettings {
    std::string executable = TRIBUS_PROGRAM;
    /// A tty that becomes its controlling terminal, standard input and standard output.
    std::string terminal = {};
    /// File that becomes standard input. If empty: the terminal, or /dev/null.
    std::string input = {};
    /// A file, pipe or device that becomes standard error, which `errors` and `says` do not read
    /// then. "closed": standard error is closed. If empty: a file in the folder.
    std::string errors = {};
    /// Limit of the size of files that it writes; 0: as many bytes as the tests.
    std::size_t most_file_bytes = 0;
    /// Runtime directory, as from a service manager. If empty: the test's folder.
    std::string runtime_directory = {};
    /// Runs under an account without rights, with Debian's limits (8 MiB of locked memory and of
    /// stack, no real-time priority) and without the heap trap. If the tests do not run as root:
    /// their own account.
    bool ordinary_user = false;
    std::size_t most_locked_bytes = 8 << 20;  ///< limit of an ordinary user
    std::size_t most_descriptors = 0;         ///< 0: as many as the tests
    /// Numbers of system calls that a filter refuses with EPERM, as systemd's SystemCallFilter= and
    /// containers do.
    std::vector<long> refused_calls = {};
};

/// A running program, with the heap trap. It is killed with its object, and when the test dies.
class Program {
  public:
    /// Starts the program. Its output goes to files in `folder`.
    Program(const std::filesystem::path& folder, const std::vector<std::string>& arguments,
            const ProgramSettings& settings = {});
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;
    ~Program();

    pid_t pid() const { return pid_; }
    void signal(int number) const;
    bool runs();
    /// Processor time used so far.
    std::chrono::nanoseconds used_time() const;
    /// Number of open descriptors. The lowest of several counts is returned, because the program
    /// opens some files only for a moment.
    std::ptrdiff_t open_descriptors() const;
    /// Value in KiB of a line of /proc/PID/status, such as "VmRSS".
    long memory_kib(const std::string& line) const;
    /// Peak of its memory in KiB, after its end. At least that of this process, of which it is a
    /// copy at first.
    long peak_kib() const { return peak_kib_; }
    /// Waits for the end. Returns the exit status, or 128 plus the signal that ended the program.
    std::optional<int> end(std::chrono::seconds patience = kPatience);

    std::string output() const;
    std::string errors() const;
    /// Waits until standard error contains `text` `times` times.
    bool says(const std::string& text, std::size_t times = 1) const;

  private:
    [[noreturn]] void become(const std::vector<std::string>& arguments,
                             const ProgramSettings& settings, pid_t parent) const;
    void note_end(int status);

    std::string output_file_;
    std::string errors_file_;
    pid_t pid_ = -1;
    std::optional<int> ended_;
    long peak_kib_ = 0;
};

/// Returns how often `text` contains `part`.
std::size_t count_of(const std::string& part, const std::string& text);

}  // namespace tribus::test
