#include "tests/lab/shell.h"

#include <fcntl.h>
#include <poll.h>
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

[[noreturn]] void become_shell(const std::string& command, int output) {
    ::setpgid(0, 0);
    const int nothing = ::open("/dev/null", O_RDONLY);
    ::dup2(nothing, STDIN_FILENO);
    ::dup2(output, STDOUT_FILENO);
    ::dup2(output, STDERR_FILENO);
    ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    ::_exit(kBySignal - 1);
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
    const pid_t pid = ::fork();
    if (pid == 0) {
        become_shell(command, input.get());
    }
    input.reset();
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
