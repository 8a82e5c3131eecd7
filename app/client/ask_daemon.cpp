#include "app/client/ask_daemon.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/client/control_socket.h"
#include "app/client/parse_json.h"
#include "app/client/status_fields.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

using Refused = tl::unexpected<std::string>;

/// Reads a line, without its end. The error continues the sentence "the daemon at ...".
tl::expected<std::string, std::string> read_line(int descriptor, Instant end) {
    constexpr std::size_t kBytesAtOnce = 16384;
    std::array<char, kBytesAtOnce> bytes;
    std::string received;
    for (;;) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - monotonic_now());
        if (left.count() <= 0) {
            return Refused("does not answer");
        }
        pollfd socket{.fd = descriptor, .events = POLLIN, .revents = 0};
        if (::poll(&socket, 1, static_cast<int>(left.count())) <= 0) {
            continue;
        }
        const ssize_t count = ::recv(descriptor, bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) {
            return Refused("closed the connection without an answer");
        }
        received.append(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
        if (const auto line_end = received.find('\n'); line_end != std::string::npos) {
            return received.substr(0, line_end);
        }
    }
}

std::vector<FoundSocket> sockets_for(Wants wants) {
    const SocketDirectories directories = SocketDirectories::of_this_process();
    std::vector<FoundSocket> found = find_sockets(directories);
    if (wants == Wants::change) {
        return found;
    }
    for (FoundSocket& telling : find_telling_sockets(directories)) {
        const bool known = std::ranges::any_of(found, [&](const FoundSocket& control) {
            return telling.path == control.path || telling.path == look_socket(control.path);
        });
        if (!known) {
            found.push_back(std::move(telling));
        }
    }
    std::ranges::sort(found, {}, &FoundSocket::name);
    return found;
}

}  // namespace

std::vector<std::string> running_daemons() {
    std::vector<std::string> names;
    for (FoundSocket& daemon : sockets_for(Wants::look)) {
        names.push_back(std::move(daemon.name));
    }
    return names;
}

CommandOption daemon_name_option(std::string& name) {
    return {.name = "NAME",
            .value = &name,
            .help = "Name of the daemon's configuration file; needed if several run",
            .offers = running_daemons};
}

CommandOption daemon_socket_option(std::optional<std::string>& socket) {
    return {.name = "--socket",
            .value = &socket,
            .help = "The daemon's control socket, if it is not in the default place",
            .value_name = "SOCKET"};
}

tl::expected<std::string, std::string> find_daemon(const std::string& name,
                                                   const std::optional<std::string>& socket,
                                                   Wants wants) {
    if (socket) {
        return *socket;
    }
    const std::filesystem::path file(name);
    const std::string wanted = file.extension() == ".toml" ? file.stem().string() : name;
    const std::vector<FoundSocket> found = sockets_for(wants);
    std::string names;
    std::vector<std::string> matches;
    for (const FoundSocket& daemon : found) {
        names += (names.empty() ? "" : ", ") + daemon.name;
        if (wanted.empty() || wanted == daemon.name) {
            matches.push_back(daemon.path);
        }
    }
    if (matches.size() == 1) {
        return matches.front();
    }
    if (found.empty()) {
        return Refused(
            "no running tribus found that this user may access; `tribus run` starts one, --socket "
            "PATH names the socket of one elsewhere");
    }
    return Refused(
        matches.empty()
            ? fmt::format("no daemon is called {}; running: {}", wanted, names)
            : fmt::format("several daemons run; name one of them, or use --socket PATH: {}",
                          names));
}

tl::expected<nlohmann::json, std::string> ask_daemon(const std::string& socket,
                                                     std::string_view request, Duration patience) {
    const auto connection = connect_local(socket);
    if (!connection) {
        return Refused(
            fmt::format("no daemon answers at {}: {}", socket, std::strerror(connection.error())));
    }
    const std::string line = std::string(request) + "\n";
    if (::send(connection->get(), line.data(), line.size(), MSG_NOSIGNAL) !=
        static_cast<ssize_t>(line.size())) {
        return Refused(fmt::format("the daemon at {} does not take the request: {}", socket,
                                   std::strerror(errno)));
    }
    const auto text = read_line(connection->get(), later(monotonic_now(), patience));
    if (!text) {
        return Refused(fmt::format("the daemon at {} {}", socket, text.error()));
    }
    nlohmann::json answer = parse_json(*text);
    if (!answer.is_object()) {
        return Refused(fmt::format("the program at {} is not tribus", socket));
    }
    if (status_fields::text(answer, "type") == "error") {
        return Refused(status_fields::text(answer, "error"));
    }
    return answer;
}

}  // namespace tribus
