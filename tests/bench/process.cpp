#include "tests/bench/process.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>
#include <utility>

namespace tribus::bench {
namespace {

constexpr int kCannotStart = 127;
constexpr int kBySignal = 128;

/// Sets up the new process: it ends with its parent, and signals of the terminal do not reach it.
void set_up_child(pid_t parent, int errors) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) {
        ::_exit(kCannotStart);
    }
    // Not in its own session: the scheduler would give each session an equal share of the processor
    // (sched_autogroup), which programs started from one shell do not have.
    ::setpgid(0, 0);
    sigset_t none;
    ::sigemptyset(&none);
    ::pthread_sigmask(SIG_SETMASK, &none, nullptr);
    ::signal(SIGINT, SIG_DFL);
    ::signal(SIGTERM, SIG_DFL);
    const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    ::dup2(nothing, STDIN_FILENO);
    ::dup2(nothing, STDOUT_FILENO);
    ::dup2(errors, STDERR_FILENO);
}

UniqueFd make_errors() {
    return UniqueFd(::memfd_create("errors", MFD_CLOEXEC));
}

/// The number after `name` in a file with lines such as "VmRSS:   1234 kB".
std::size_t kilobytes(const std::string& status, std::string_view name) {
    const std::size_t at = status.find(name);
    if (at == std::string::npos) {
        return 0;
    }
    std::istringstream rest(status.substr(at + name.size()));
    std::size_t value = 0;
    rest >> value;
    return value;
}

Duration processor_time(const std::filesystem::path& process) {
    Duration sum{};
    std::error_code ignored;
    for (const auto& task : std::filesystem::directory_iterator(process / "task", ignored)) {
        std::istringstream figures(content_of(task.path() / "schedstat"));
        std::int64_t nanoseconds = 0;
        figures >> nanoseconds;
        sum += Duration(nanoseconds);
    }
    return sum;
}

}  // namespace

Process::Process(pid_t id, UniqueFd errors) : id_(id), errors_(std::move(errors)) {}

Process::Process(Process&& other) noexcept
    : id_(std::exchange(other.id_, -1)), errors_(std::move(other.errors_)), ended_(other.ended_) {}

Process& Process::operator=(Process&& other) noexcept {
    if (this != &other) {
        end();
        id_ = std::exchange(other.id_, -1);
        errors_ = std::move(other.errors_);
        ended_ = other.ended_;
    }
    return *this;
}

Process::~Process() {
    end();
}

tl::expected<Process, std::string> Process::fork(const std::function<int()>& body) {
    UniqueFd errors = make_errors();
    const pid_t parent = ::getpid();
    const pid_t id = ::fork();
    if (id < 0) {
        return tl::unexpected(std::string("cannot start a process: ") + std::strerror(errno));
    }
    if (id == 0) {
        set_up_child(parent, errors.get());
        ::_exit(body());
    }
    return Process(id, std::move(errors));
}

tl::expected<Process, std::string> Process::execute(const std::vector<std::string>& words,
                                                    const std::vector<int>& passed,
                                                    const std::vector<std::string>& environment) {
    std::vector<std::string> copies = words;
    std::vector<char*> arguments;
    arguments.reserve(copies.size() + 1);
    for (std::string& word : copies) {
        arguments.push_back(word.data());
    }
    arguments.push_back(nullptr);
    return fork([&] {
        for (const int descriptor : passed) {
            ::fcntl(descriptor, F_SETFD, 0);
        }
        for (const std::string& assignment : environment) {
            ::putenv(const_cast<char*>(assignment.c_str()));
        }
        ::execvp(arguments.front(), arguments.data());
        const std::string reason = words.front() + ": " + std::strerror(errno);
        [[maybe_unused]] const auto written = ::write(STDERR_FILENO, reason.data(), reason.size());
        return kCannotStart;
    });
}

bool Process::runs() {
    int status = 0;
    if (id_ > 0 && !ended_ && ::waitpid(id_, &status, WNOHANG) == id_) {
        ended_ = WIFEXITED(status) ? WEXITSTATUS(status) : kBySignal + WTERMSIG(status);
    }
    return id_ > 0 && !ended_;
}

int Process::end() {
    constexpr int kPolls = 2000;
    // Repeated, because a process that was just forked still has its parent's signal handlers.
    constexpr int kPollsPerRequest = 100;
    constexpr timespec kMillisecond{.tv_sec = 0, .tv_nsec = 1'000'000};
    for (int i = 0; i < kPolls && runs(); ++i) {
        if (i % kPollsPerRequest == 0) {
            ::kill(id_, SIGTERM);
        }
        ::nanosleep(&kMillisecond, nullptr);
    }
    while (runs()) {
        ::kill(id_, SIGKILL);
        ::nanosleep(&kMillisecond, nullptr);
    }
    return ended_.value_or(0);
}

std::string Process::errors() const {
    std::string text;
    std::array<char, 4096> buffer{};
    ssize_t count = 0;
    while ((count = ::pread(errors_.get(), buffer.data(), buffer.size(),
                            static_cast<off_t>(text.size()))) > 0) {
        text.append(buffer.data(), static_cast<std::size_t>(count));
    }
    return text;
}

std::string content_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::optional<ProcessUsage> usage_of(pid_t process) {
    constexpr std::size_t kKilobyte = 1024;
    const std::filesystem::path folder = "/proc/" + std::to_string(process);
    const std::string status = content_of(folder / "status");
    if (status.empty()) {
        return std::nullopt;
    }
    ProcessUsage usage;
    usage.resident_bytes = kilobytes(status, "VmRSS:") * kKilobyte;
    usage.anonymous_bytes = kilobytes(status, "RssAnon:") * kKilobyte;
    usage.locked_bytes = kilobytes(status, "VmLck:") * kKilobyte;
    usage.processor_time = processor_time(folder);
    return usage;
}

}  // namespace tribus::bench
