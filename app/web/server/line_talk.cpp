#include "app/web/server/line_talk.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/client/control_socket.h"

namespace tribus::web {
namespace {

using NoHelper = tl::unexpected<std::string>;

constexpr std::size_t kLongestLine = std::size_t{8} << 20U;

/// What a child needs to begin as a program from a shell does.
class ChildSettings {
  public:
    explicit ChildSettings(int connection) {
        ::posix_spawn_file_actions_init(&files_);
        ::posix_spawn_file_actions_adddup2(&files_, connection, STDIN_FILENO);
        ::posix_spawn_file_actions_adddup2(&files_, connection, STDOUT_FILENO);
        ::posix_spawnattr_init(&attributes_);
        sigset_t none;
        sigset_t defaults;
        ::sigemptyset(&none);
        ::sigemptyset(&defaults);
        ::sigaddset(&defaults, SIGCHLD);
        ::posix_spawnattr_setsigmask(&attributes_, &none);
        ::posix_spawnattr_setsigdefault(&attributes_, &defaults);
        ::posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    }
    ChildSettings(const ChildSettings&) = delete;
    ChildSettings& operator=(const ChildSettings&) = delete;
    ~ChildSettings() {
        ::posix_spawn_file_actions_destroy(&files_);
        ::posix_spawnattr_destroy(&attributes_);
    }

    const posix_spawn_file_actions_t* files() const { return &files_; }
    const posix_spawnattr_t* attributes() const { return &attributes_; }

  private:
    posix_spawn_file_actions_t files_{};
    posix_spawnattr_t attributes_{};
};

/// Its end is that of its connection; nobody waits for it.
tl::expected<UniqueFd, std::string> helper_as_child(std::string configurations) {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
        return NoHelper(fmt::format("no socket for the helper: {}", std::strerror(errno)));
    }
    UniqueFd ours(ends[0]);
    const UniqueFd theirs(ends[1]);
    const ChildSettings settings(theirs.get());
    std::string self("/proc/self/exe");
    std::string verb("ports");
    std::string option("--configurations");
    const std::array<char*, 5> arguments{self.data(), verb.data(), option.data(),
                                         configurations.data(), nullptr};
    ::signal(SIGCHLD, SIG_IGN);
    const int error = ::posix_spawn(nullptr, self.c_str(), settings.files(), settings.attributes(),
                                    arguments.data(), environ);
    if (error != 0) {
        return NoHelper(
            fmt::format("the helper for ports does not start: {}", std::strerror(error)));
    }
    return ours;
}

}  // namespace

LineTalk::LineTalk(std::string_view who, tl::expected<UniqueFd, std::string> socket) : who_(who) {
    if (socket) {
        socket_ = std::move(*socket);
    } else {
        failed_ = socket.error();
    }
}

void LineTalk::say(std::string_view line) {
    const std::string text = std::string(line) + "\n";
    if (failed_.empty() &&
        ::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT) !=
            static_cast<ssize_t>(text.size())) {
        failed_ = who_ + " takes no request";
    }
}

std::optional<std::string> LineTalk::hear() {
    constexpr std::size_t kBytesAtOnce = 16384;
    std::array<char, kBytesAtOnce> bytes;
    while (failed_.empty()) {
        const ssize_t count = ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (count > 0) {
            received_.append(bytes.data(), static_cast<std::size_t>(count));
            if (received_.size() > kLongestLine) {
                failed_ = who_ + " says too much";
            }
            continue;
        }
        if (count == 0 || (errno != EAGAIN && errno != EINTR)) {
            failed_ = who_ + " ended before it answered";
        }
        break;
    }
    const std::size_t end = received_.find('\n');
    if (end == std::string::npos) {
        return std::nullopt;
    }
    std::string line = received_.substr(0, end);
    received_.erase(0, end + 1);
    return line;
}

tl::expected<UniqueFd, std::string> start_ports_helper(const std::string& path,
                                                       const std::string& configurations) {
    if (path.empty()) {
        return helper_as_child(configurations);
    }
    auto connected = connect_local(path);
    if (!connected) {
        return NoHelper(fmt::format("the helper for ports does not answer at {}: {}", path,
                                    std::strerror(connected.error())));
    }
    return std::move(*connected);
}

}  // namespace tribus::web
