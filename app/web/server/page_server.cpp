#include "app/web/server/page_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include <fmt/format.h>

namespace tribus::web {
namespace {

using Refused = tl::unexpected<std::string>;

constexpr std::size_t kMostClients = 16;
constexpr Duration kHeadPatience = std::chrono::seconds(5);
constexpr Duration kReadPatience = std::chrono::seconds(10);
constexpr int kFirstInherited = 3;
/// What the kernel holds of a page that does not read must not become old.
constexpr int kSendBufferBytes = 32 * 1024;

void prepare(int listener) {
    const int size = kSendBufferBytes;
    const int on = 1;
    ::setsockopt(listener, SOL_SOCKET, SO_SNDBUF, &size, sizeof size);
    ::setsockopt(listener, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    ::fcntl(listener, F_SETFL, ::fcntl(listener, F_GETFL) | O_NONBLOCK);
    ::fcntl(listener, F_SETFD, FD_CLOEXEC);
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

struct AddressDeleter {
    void operator()(addrinfo* address) const { ::freeaddrinfo(address); }
};
using Address = std::unique_ptr<addrinfo, AddressDeleter>;

Address resolve(const std::string& text) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos || colon + 1 == text.size()) {
        return nullptr;
    }
    std::string host = text.substr(0, colon);
    if (host.starts_with('[') && host.ends_with(']')) {
        host = host.substr(1, host.size() - 2);
    }
    addrinfo hints{};
    hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    const int error = ::getaddrinfo(host.c_str(), text.substr(colon + 1).c_str(), &hints, &found);
    return Address(error == 0 ? found : nullptr);
}

}  // namespace

std::vector<UniqueFd> inherited_listeners() {
    const char* const pid = std::getenv("LISTEN_PID");
    const char* const count = std::getenv("LISTEN_FDS");
    std::vector<UniqueFd> listeners;
    if (pid == nullptr || count == nullptr || std::to_string(::getpid()) != pid) {
        return listeners;
    }
    const int most = std::clamp(std::atoi(count), 0, 8);
    for (int i = 0; i < most; ++i) {
        prepare(kFirstInherited + i);
        listeners.emplace_back(kFirstInherited + i);
    }
    return listeners;
}

tl::expected<UniqueFd, std::string> listen_at(const std::string& text, bool is_public) {
    const Address address = resolve(text);
    if (!address) {
        return Refused(fmt::format(
            "the page cannot be served at \"{}\"; allowed: \"127.0.0.1:8480\", \"[::1]:8480\"",
            text));
    }
    if (!is_public && !is_loopback(*address)) {
        return Refused(fmt::format(
            "{} can be reached from the network, and nothing on the way is encrypted; use "
            "127.0.0.1 or [::1], or allow it with --public",
            text));
    }
    UniqueFd socket(::socket(address->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const int on = 1;
    ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (socket.valid()) {
        prepare(socket.get());
    }
    if (!socket.valid() || ::bind(socket.get(), address->ai_addr, address->ai_addrlen) != 0 ||
        ::listen(socket.get(), static_cast<int>(kMostClients)) != 0) {
        return Refused(
            fmt::format("the page cannot be served at {}: {}", text, std::strerror(errno)));
    }
    return socket;
}

std::string address_of_listener(const UniqueFd& listener) {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    std::array<char, NI_MAXHOST> host{};
    std::array<char, NI_MAXSERV> port{};
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    if (::getsockname(listener.get(), any, &size) != 0 ||
        ::getnameinfo(any, size, host.data(), host.size(), port.data(), port.size(),
                      NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
        return {};
    }
    const std::string name(host.data());
    return fmt::format("{}:{}", address.ss_family == AF_INET6 ? "[" + name + "]" : name,
                       port.data());
}

tl::expected<std::unique_ptr<PageServer>, std::string> PageServer::make(
    std::vector<UniqueFd> listeners, SiteSettings settings) {
    std::unique_ptr<PageServer> page(new PageServer(std::move(settings)));
    const auto request = [site = &page->site_](SocketClient& client, Instant now) {
        return site->answer(client, now);
    };
    const auto repeat = [](SocketClient& client, Instant now) { return client.send_next(now); };
    for (UniqueFd& listener : listeners) {
        auto server = SocketServer::make(std::move(listener),
                                         {.clients = kMostClients,
                                          .request = kLongestHead + kLongestBody,
                                          .unread = kReadPatience,
                                          .idle = kHeadPatience,
                                          .whole = Duration::max(),
                                          .refusal = {}},
                                         {.request = request, .repeat = repeat});
        if (!server) {
            return Refused(server.error());
        }
        page->servers_.push_back(std::move(*server));
    }
    return page;
}

std::vector<int> PageServer::descriptors() const {
    std::vector<int> descriptors = site_.descriptors();
    for (const SocketServer& server : servers_) {
        descriptors.push_back(server.descriptor());
    }
    return descriptors;
}

Instant PageServer::due() const {
    Instant due = site_.due();
    for (const SocketServer& server : servers_) {
        due = std::min(due, server.due());
    }
    return due;
}

void PageServer::serve(Instant now) {
    site_.look(now);
    for (SocketServer& server : servers_) {
        server.serve(now);
    }
}

bool PageServer::in_use() const {
    return site_.in_use() || std::ranges::any_of(servers_, [](const SocketServer& server) {
               return server.client_count() != 0;
           });
}

}  // namespace tribus::web
