#include "tests/lab/shell.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <gtest/gtest.h>

#include "transports/links/unique_fd.h"

namespace tribus::test {

namespace {

constexpr std::chrono::seconds kMostTime{180};
constexpr int kBySignal = 128;

/// Starts a shell in a group of its own, with `output` as both of its streams. Returns its process,
/// or -1. A copy of the test's process, as fork() makes, would take a guest tens of milliseconds.
pid_t start_shell(const std::string& command, int output) {
    posix_spawn_file_actions_t streams{};
    ::posix_spawn_file_actions_init(&streams);
    ::posix_spawn_file_actions_addopen(&streams, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(&streams, output, STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&streams, output, STDERR_FILENO);
    posix_spawnattr_t group{};
    ::posix_spawnattr_init(&group);
    ::posix_spawnattr_setflags(&group, POSIX_SPAWN_SETPGROUP);
    std::string name = "sh";
    std::string option = "-c";
    std::string text = command;
    std::array<char*, 4> words{name.data(), option.data(), text.data(), nullptr};
    pid_t pid = -1;
    const int problem = ::posix_spawn(&pid, "/bin/sh", &streams, &group, words.data(), environ);
    ::posix_spawnattr_destroy(&group);
    ::posix_spawn_file_actions_destroy(&streams);
    return problem == 0 ? pid : -1;
}

/// Reads until the end, or until the time for the command is over.
std::string read_output(int fd) {
    const auto end = std::chrono::steady_clock::now() + kMostTime;
    std::string output;
    std::array<char, 4096> buffer{};
    for (;;) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
            end - std::chrono::steady_clock::now());
        pollfd ready{.fd = fd, .events = POLLIN, .revents = 0};
        if (left.count() <= 0 || ::poll(&ready, 1, static_cast<int>(left.count())) <= 0) {
            return output + "\n(took too long)";
        }
        const ssize_t count = ::read(fd, buffer.data(), buffer.size());
        if (count <= 0) {
            return output;
        }
        output.append(buffer.data(), static_cast<std::size_t>(count));
    }
}

}  // namespace

ShellResult run_shell(const std::string& command) {
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0) {
        return {-1, std::string("no pipe: ") + std::strerror(errno)};
    }
    const UniqueFd output(pipe[0]);
    UniqueFd input(pipe[1]);
    const pid_t pid = start_shell(command, input.get());
    input.reset();
    if (pid < 0) {
        return {-1, "no shell"};
    }
    ShellResult result;
    result.output = read_output(output.get());
    // Kills what is left of it; if it has ended, nothing happens.
    ::kill(-pid, SIGKILL);
    int status = 0;
    ::waitpid(pid, &status, 0);
    result.status = WIFEXITED(status) ? WEXITSTATUS(status) : kBySignal + WTERMSIG(status);
    return result;
}

std::string shell(const std::string& command) {
    const ShellResult result = run_shell(command);
    EXPECT_EQ(result.status, 0) << command << "\n" << result.output;
    return result.output;
}

void require_guest() {
    if (std::getenv("TRIBUS_IN_LAB") == nullptr) {
        throw std::runtime_error("this test needs a guest of the laboratory");
    }
}

void write_kernel_file(const std::filesystem::path& path, const std::string& text) {
    const UniqueFd file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    ASSERT_TRUE(file.valid()) << path << ": " << std::strerror(errno);
    ASSERT_EQ(::write(file.get(), text.data(), text.size()), std::ssize(text))
        << path << ": " << text << ": " << std::strerror(errno);
}

std::string read_file(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(file), {}};
    while (!text.empty() && text.back() == '\n') {
        text.pop_back();
    }
    return text;
}

}  // namespace tribus::test
