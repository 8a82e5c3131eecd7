#include "app/daemon/metrics_server.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace tribus {
namespace {

using Refused = tl::unexpected<std::string>;

/// A scraper sends one request and leaves; there are one or two of them.
constexpr std::size_t kMostClients = 4;
constexpr std::size_t kLongestHead = 4096;
constexpr Duration kClientPatience = std::chrono::seconds(5);
constexpr Duration kLongestConnection = std::chrono::seconds(10);

struct AddressDeleter {
    void operator()(addrinfo* address) const { ::freeaddrinfo(address); }
};
using Address = std::unique_ptr<addrinfo, AddressDeleter>;

/// getaddrinfo(3) would accept an empty port as any, and of one that is too large its lower 16
/// bits.
bool is_port(const std::string& text) {
    std::uint16_t port = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), port);
    return !text.empty() && read.ec == std::errc() && read.ptr == text.data() + text.size();
}

Address resolve(const std::string& text) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos || !is_port(text.substr(colon + 1))) {
        return nullptr;
    }
    std::string host = text.substr(0, colon);
    if (host.starts_with('[') && host.ends_with(']')) {
        host = host.substr(1, host.size() - 2);
    } else if (host.find(':') != std::string::npos) {
        return nullptr;
    }
    addrinfo hints{};
    hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    const int error = ::getaddrinfo(host.c_str(), text.substr(colon + 1).c_str(), &hints, &found);
    return Address(error == 0 ? found : nullptr);
}

bool is_loopback(const addrinfo& address) {
    if (address.ai_family == AF_INET) {
        sockaddr_in v4{};
        std::memcpy(&v4, address.ai_addr, sizeof v4);
        constexpr std::uint32_t kLoopbackNet = 127;
        return ntohl(v4.sin_addr.s_addr) >> 24U == kLoopbackNet;
    }
    sockaddr_in6 v6{};
    std::memcpy(&v6, address.ai_addr, sizeof v6);
    return std::memcmp(&v6.sin6_addr, &in6addr_loopback, sizeof v6.sin6_addr) == 0;
}

tl::expected<UniqueFd, std::string> listen_on(const std::string& text, MetricsReach reach) {
    const Address address = resolve(text);
    if (!address) {
        return Refused(
            fmt::format("metrics cannot be served at \"{}\"; allowed: \"127.0.0.1:9464\", "
                        "\"[::1]:9464\", or the path of a local socket",
                        text));
    }
    if (reach == MetricsReach::local && !is_loopback(*address)) {
        return Refused(
            fmt::format("{} can be reached from the network, and nothing asks who reads; use "
                        "127.0.0.1 or [::1], or allow it with --metrics-public",
                        text));
    }
    UniqueFd socket(::socket(address->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const int on = 1;
    ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (!socket.valid() || ::bind(socket.get(), address->ai_addr, address->ai_addrlen) != 0 ||
        ::listen(socket.get(), static_cast<int>(kMostClients)) != 0) {
        return Refused(
            fmt::format("metrics cannot be served at {}: {}", text, std::strerror(errno)));
    }
    return socket;
}

std::string response(std::string_view status, std::string_view content) {
    return fmt::format(
        "HTTP/1.1 {}\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\n"
        "Content-Length: {}\r\nConnection: close\r\n\r\n{}",
        status, content.size(), content);
}

bool head_is_complete(std::string_view received) {
    return received.find("\r\n\r\n") != std::string_view::npos ||
           received.find("\n\n") != std::string_view::npos;
}

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t");
    return begin == std::string_view::npos
               ? std::string_view()
               : text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

bool same_but_for_case(std::string_view a, std::string_view b) {
    return std::ranges::equal(
        a, b, {}, [](unsigned char c) { return std::tolower(c); },
        [](unsigned char c) { return std::tolower(c); });
}

/// True for an IP address or localhost, with or without a port.
bool is_own_host(std::string_view host) {
    const std::size_t bracket = host.find(']');
    const bool v6 = host.starts_with('[') && bracket != std::string_view::npos;
    const std::string name(v6 ? host.substr(1, bracket - 1) : host.substr(0, host.find(':')));
    in6_addr address{};
    return v6 ? ::inet_pton(AF_INET6, name.c_str(), &address) == 1
              : same_but_for_case(name, "localhost") ||
                    ::inet_pton(AF_INET, name.c_str(), &address) == 1;
}

/// Requests without a Host line pass: every browser sends one.
bool asks_this_machine(std::string_view head) {
    constexpr std::string_view kHost = "host:";
    while (!head.empty()) {
        const std::size_t end = head.find('\n');
        const std::string_view line = head.substr(0, end);
        if (same_but_for_case(line.substr(0, kHost.size()), kHost) &&
            !is_own_host(trimmed(line.substr(kHost.size())))) {
            return false;
        }
        head.remove_prefix(end == std::string_view::npos ? head.size() : end + 1);
    }
    return true;
}

}  // namespace

std::string http_response(std::string_view head, HostNames allowed,
                          const std::function<std::string()>& metrics) {
    const std::string_view line = head.substr(0, head.find_first_of("\r\n"));
    const std::size_t target = line.find(' ');
    const std::size_t version = line.rfind(' ');
    if (target == std::string_view::npos || version == target ||
        !line.substr(version + 1).starts_with("HTTP/1.")) {
        return response("400 Bad Request", "not HTTP/1.1\n");
    }
    if (line.substr(0, target) != "GET") {
        return response("405 Method Not Allowed", "only GET\n");
    }
    if (allowed == HostNames::own && !asks_this_machine(head)) {
        return response("421 Misdirected Request",
                        "the host must be an address or localhost, not another name\n");
    }
    std::string_view path = line.substr(target + 1, version - target - 1);
    path = path.substr(0, path.find('?'));
    return path == "/metrics" ? response("200 OK", metrics())
                              : response("404 Not Found", "metrics are at /metrics\n");
}

tl::expected<std::unique_ptr<MetricsServer>, std::string> MetricsServer::open(
    const std::string& address, MetricsReach reach, std::function<std::string()> metrics) {
    std::unique_ptr<MetricsServer> server(new MetricsServer);
    UniqueFd listening;
    const bool own_names = reach == MetricsReach::local && !address.starts_with('/');
    const HostNames allowed = own_names ? HostNames::own : HostNames::any;
    if (address.starts_with('/')) {
        auto listener = LocalListener::open(address);
        if (!listener) {
            return Refused(listener.error());
        }
        server->listener_.emplace(std::move(*listener));
        listening = std::move(server->listener_->descriptor());
    } else {
        auto socket = listen_on(address, reach);
        if (!socket) {
            return Refused(socket.error());
        }
        listening = std::move(*socket);
    }
    const auto request = [allowed, metrics = std::move(metrics)](SocketClient& client,
                                                                 Instant now) {
        const bool complete = head_is_complete(client.received());
        if (!complete && !client.request_too_long()) {
            return true;
        }
        client.close_when_sent();
        return client.send(complete ? http_response(client.received(), allowed, metrics)
                                    : response("431 Request Header Fields Too Large", ""),
                           now);
    };
    const auto never = [](SocketClient&, Instant) { return false; };
    auto made = SocketServer::make(std::move(listening),
                                   {.clients = kMostClients,
                                    .request = kLongestHead,
                                    .unread = kClientPatience,
                                    .idle = kClientPatience,
                                    .whole = kLongestConnection,
                                    .refusal = {}},
                                   {.request = request, .repeat = never});
    if (!made) {
        return Refused(made.error());
    }
    server->server_.emplace(std::move(*made));
    return server;
}

}  // namespace tribus
