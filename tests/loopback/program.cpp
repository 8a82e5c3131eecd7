#include "tests/loopback/program.h"

#include <fcntl.h>
#include <grp.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "tests/support/sanitized.h"

namespace tribus::test {
namespace {

constexpr int kCannotStart = 127;

std::string content_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::string unused_name(const std::filesystem::path& folder, const std::string& kind) {
    int number = 1;
    std::filesystem::path path;
    do {
        path = folder / (kind + std::to_string(number++));
    } while (std::filesystem::exists(path));
    const std::ofstream file(path);
    return path;
}

void redirect(int stream, const std::string& path, int flags) {
    const int fd = ::open(path.c_str(), flags, 0600);
    if (fd < 0 || ::dup2(fd, stream) < 0) {
        ::_exit(kCannotStart);
    }
}

void lower_limit(__rlimit_resource resource, rlim_t most) {
    rlimit limit{};
    ::getrlimit(resource, &limit);
    limit.rlim_max = std::min(limit.rlim_max, most);
    limit.rlim_cur = limit.rlim_max;
    if (::setrlimit(resource, &limit) != 0) {
        ::_exit(kCannotStart);
    }
}

/// A filter of seccomp(2): a program for the numbers of system calls.
void refuse_calls(const std::vector<long>& numbers) {
    std::vector<sock_filter> rules{BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr))};
    for (const long number : numbers) {
        rules.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<__u32>(number), 0, 1));
        rules.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM));
    }
    rules.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
    sock_fprog program{.len = static_cast<unsigned short>(rules.size()), .filter = rules.data()};
    if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
        ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0) {
        ::_exit(kCannotStart);
    }
}

void become_ordinary_user(rlim_t most_locked_bytes) {
    constexpr rlim_t kDebiansStack = 8 << 20;
    constexpr uid_t kUser = kOrdinaryUser;
    lower_limit(RLIMIT_MEMLOCK, most_locked_bytes);
    lower_limit(RLIMIT_STACK, kDebiansStack);
    lower_limit(RLIMIT_RTPRIO, 0);
    if (::geteuid() == 0 &&
        (::setgroups(0, nullptr) != 0 || ::setgid(kUser) != 0 || ::setuid(kUser) != 0)) {
        ::_exit(kCannotStart);
    }
    // A change of account clears this setting, so it is set again.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
}

}  // namespace

Program::Program(const std::filesystem::path& folder, const std::vector<std::string>& arguments,
                 const ProgramSettings& settings)
    : output_file_(unused_name(folder, "output")), errors_file_(unused_name(folder, "errors")) {
    const pid_t parent = ::getpid();
    pid_ = ::fork();
    if (pid_ < 0) {
        throw std::runtime_error("cannot fork");
    }
    if (pid_ == 0) {
        become(arguments, settings, parent);
    }
}

void Program::become(const std::vector<std::string>& arguments, const ProgramSettings& settings,
                     pid_t parent) const {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) {
        ::_exit(kCannotStart);
    }
    ::setsid();
    // A shell that runs the tests in the background makes them ignore it.
    ::signal(SIGINT, SIG_DFL);
    redirect(STDIN_FILENO, settings.input.empty() ? "/dev/null" : settings.input, O_RDONLY);
    redirect(STDERR_FILENO, errors_file_, O_WRONLY | O_TRUNC | O_APPEND);
    if (settings.errors == "closed") {
        ::close(STDERR_FILENO);
    } else if (!settings.errors.empty()) {
        redirect(STDERR_FILENO, settings.errors, O_WRONLY | O_APPEND);
    }
    if (settings.most_file_bytes != 0) {
        lower_limit(RLIMIT_FSIZE, settings.most_file_bytes);
    }
    if (settings.terminal.empty()) {
        redirect(STDOUT_FILENO, output_file_, O_WRONLY | O_TRUNC);
    } else {
        redirect(STDIN_FILENO, settings.terminal, O_RDWR);
        redirect(STDOUT_FILENO, settings.terminal, O_RDWR);
        ::ioctl(STDOUT_FILENO, TIOCSCTTY, 0);
    }
    // Folder of the control socket, so that tests that run at the same time do not share it.
    const std::string runtime = settings.runtime_directory.empty()
                                    ? std::filesystem::path(output_file_).parent_path().string()
                                    : settings.runtime_directory;
    ::setenv("RUNTIME_DIRECTORY", runtime.c_str(), 1);
    if (settings.ordinary_user) {
        become_ordinary_user(settings.most_locked_bytes);
    } else if (!kSanitized) {
        ::setenv("LD_PRELOAD", TRIBUS_HEAP_TRAP, 1);
    }
    if (settings.most_descriptors != 0) {
        lower_limit(RLIMIT_NOFILE, settings.most_descriptors);
    }
    if (!settings.refused_calls.empty()) {
        refuse_calls(settings.refused_calls);
    }
    std::string name = settings.executable;
    std::vector<std::string> words = arguments;
    std::vector<char*> argv{name.data()};
    for (std::string& word : words) {
        argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    ::execv(name.c_str(), argv.data());
    ::_exit(kCannotStart);
}

Program::~Program() {
    if (!ended_) {
        ::kill(pid_, SIGKILL);
        ::waitpid(pid_, nullptr, 0);
    }
}

void Program::signal(int number) const {
    if (!ended_) {
        ::kill(pid_, number);
    }
}

void Program::note_end(int status) {
    constexpr int kBySignal = 128;
    ended_ = WIFEXITED(status) ? WEXITSTATUS(status) : kBySignal + WTERMSIG(status);
}

bool Program::runs() {
    int status = 0;
    rusage usage{};
    if (!ended_ && ::wait4(pid_, &status, WNOHANG, &usage) == pid_) {
        note_end(status);
        peak_kib_ = usage.ru_maxrss;
    }
    return !ended_;
}

std::chrono::nanoseconds Program::used_time() const {
    clockid_t clock{};
    timespec used{};
    if (::clock_getcpuclockid(pid_, &clock) != 0 || ::clock_gettime(clock, &used) != 0) {
        throw std::runtime_error("the program has no process");
    }
    return std::chrono::seconds(used.tv_sec) + std::chrono::nanoseconds(used.tv_nsec);
}

std::ptrdiff_t Program::open_descriptors() const {
    constexpr int kLooks = 20;
    constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 1'000'000};
    std::ptrdiff_t fewest = PTRDIFF_MAX;
    for (int look = 0; look < kLooks; ++look) {
        const std::filesystem::directory_iterator entries("/proc/" + std::to_string(pid_) + "/fd");
        fewest = std::min(
            fewest, std::distance(std::filesystem::begin(entries), std::filesystem::end(entries)));
        ::nanosleep(&kPause, nullptr);
    }
    return fewest;
}

long Program::memory_kib(const std::string& line) const {
    const std::string status = content_of("/proc/" + std::to_string(pid_) + "/status");
    const std::size_t at = status.find(line + ":");
    if (at == std::string::npos) {
        throw std::runtime_error("the program has no process");
    }
    return std::stol(status.substr(at + line.size() + 1));
}

std::optional<int> Program::end(std::chrono::seconds patience) {
    eventually([this] { return !runs(); }, patience);
    return ended_;
}

std::string Program::output() const {
    return content_of(output_file_);
}

std::string Program::errors() const {
    return content_of(errors_file_);
}

bool Program::says(const std::string& text, std::size_t times) const {
    return eventually([&] { return count_of(text, errors()) >= times; });
}

std::size_t count_of(const std::string& part, const std::string& text) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos;
         at = text.find(part, at + part.size())) {
        ++count;
    }
    return count;
}

}  // namespace tribus::test
