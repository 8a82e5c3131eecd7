#include "app/web/answers/line_talk.h"

#include <sys/socket.h>
#include <sys/wait.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/client/control_socket.h"
#include "app/web/answers/own_process.h"

namespace tribus::web {
namespace {

using NoHelper = tl::unexpected<std::string>;

constexpr std::size_t kLongestLine = std::size_t{8} << 20U;

/// The end of a helper comes with that of its connection. Nobody waits for it: those that have
/// ended are taken away when the next one starts.
void take_away_ended(std::vector<pid_t>& helpers) {
    std::erase_if(helpers, [](pid_t helper) { return ::waitpid(helper, nullptr, WNOHANG) != 0; });
}

tl::expected<UniqueFd, std::string> helper_as_child(const std::string& configurations) {
    static std::vector<pid_t> helpers;
    take_away_ended(helpers);
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
        return NoHelper(fmt::format("no socket for the helper: {}", std::strerror(errno)));
    }
    UniqueFd ours(ends[0]);
    const UniqueFd theirs(ends[1]);
    const auto helper = start_own_program({"ports", "--configurations", configurations},
                                          {.input = theirs.get(), .output = theirs.get()});
    if (!helper) {
        return NoHelper(
            fmt::format("the helper for ports does not start: {}", std::strerror(helper.error())));
    }
    helpers.push_back(*helper);
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
