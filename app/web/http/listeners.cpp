#include "app/web/http/listeners.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <memory>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace tribus::web {
namespace {

using NoListener = tl::unexpected<std::string>;

constexpr int kFirstInherited = 3;
constexpr int kMostInherited = 8;
constexpr int kMostUnaccepted = 16;
/// The kernel holds so much for a page that does not read; it must not become old.
constexpr int kSendBufferBytes = 32 * 1024;

void prepare(int listener) {
    const int size = kSendBufferBytes;
    const int on = 1;
    ::setsockopt(listener, SOL_SOCKET, SO_SNDBUF, &size, sizeof size);
    ::setsockopt(listener, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    ::fcntl(listener, F_SETFL, ::fcntl(listener, F_GETFL) | O_NONBLOCK);
    ::fcntl(listener, F_SETFD, FD_CLOEXEC);
}

struct AddressDeleter {
    void operator()(addrinfo* address) const { ::freeaddrinfo(address); }
};
using Address = std::unique_ptr<addrinfo, AddressDeleter>;

/// getaddrinfo(3) would take an empty port as any, and of one that is too large its lower 16 bits.
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

/// Local sockets, too: the network cannot reach them.
bool stays_on_this_machine(const sockaddr& address) {
    if (address.sa_family == AF_INET) {
        sockaddr_in v4{};
        std::memcpy(&v4, &address, sizeof v4);
        constexpr std::uint32_t kLoopbackNet = 127;
        return ntohl(v4.sin_addr.s_addr) >> 24U == kLoopbackNet;
    }
    if (address.sa_family == AF_INET6) {
        sockaddr_in6 v6{};
        std::memcpy(&v6, &address, sizeof v6);
        return std::memcmp(&v6.sin6_addr, &in6addr_loopback, sizeof v6.sin6_addr) == 0;
    }
    return address.sa_family == AF_UNIX;
}

std::string too_public(const std::string& place) {
    return fmt::format(
        "{} can be reached from the network, and nothing on the way is encrypted; use 127.0.0.1 or "
        "[::1], or allow it with --public",
        place);
}

/// Own address of a socket; of size 0 if it is no socket.
struct OwnAddress {
    explicit OwnAddress(const UniqueFd& socket) {
        if (::getsockname(socket.get(), any(), &size) != 0) {
            size = 0;
        }
    }
    sockaddr* any() { return reinterpret_cast<sockaddr*>(&storage); }

    sockaddr_storage storage{};
    socklen_t size = sizeof storage;
};

tl::expected<Listener, std::string> listen_at_path(const std::string& path) {
    auto file = LocalListener::open(path);
    if (!file) {
        return NoListener(file.error());
    }
    prepare(file->descriptor().get());
    Listener listener{std::move(file->descriptor()), std::nullopt};
    listener.file.emplace(std::move(*file));
    return listener;
}

}  // namespace

tl::expected<std::vector<Listener>, std::string> inherited_listeners(bool is_public) {
    const char* const pid = std::getenv("LISTEN_PID");
    const char* const count = std::getenv("LISTEN_FDS");
    std::vector<Listener> listeners;
    if (pid == nullptr || count == nullptr || std::to_string(::getpid()) != pid) {
        return listeners;
    }
    const int most = std::clamp(std::atoi(count), 0, kMostInherited);
    for (int i = 0; i < most; ++i) {
        Listener listener{UniqueFd(kFirstInherited + i), std::nullopt};
        prepare(listener.socket.get());
        OwnAddress address(listener.socket);
        if (address.size == 0) {
            return NoListener(
                fmt::format("what systemd listens on is not a socket: {}", std::strerror(errno)));
        }
        if (!is_public && !stays_on_this_machine(*address.any())) {
            return NoListener(too_public(place_of(listener)));
        }
        listeners.push_back(std::move(listener));
    }
    return listeners;
}

tl::expected<Listener, std::string> listen_at(const std::string& text, bool is_public) {
    if (text.starts_with('/')) {
        return listen_at_path(text);
    }
    const Address address = resolve(text);
    if (!address) {
        return NoListener(
            fmt::format("the page cannot be served at \"{}\"; allowed: \"127.0.0.1:8480\", "
                        "\"[::1]:8480\", or the path of a local socket",
                        text));
    }
    if (!is_public && !stays_on_this_machine(*address->ai_addr)) {
        return NoListener(too_public(text));
    }
    UniqueFd socket(::socket(address->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const int on = 1;
    ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (socket.valid()) {
        prepare(socket.get());
    }
    if (!socket.valid() || ::bind(socket.get(), address->ai_addr, address->ai_addrlen) != 0 ||
        ::listen(socket.get(), kMostUnaccepted) != 0) {
        return NoListener(
            fmt::format("the page cannot be served at {}: {}", text, std::strerror(errno)));
    }
    return Listener{std::move(socket), std::nullopt};
}

std::string place_of(const Listener& listener) {
    OwnAddress address(listener.socket);
    if (address.storage.ss_family == AF_UNIX) {
        sockaddr_un local{};
        std::memcpy(&local, &address.storage, sizeof local);
        return std::string(std::data(local.sun_path));
    }
    std::array<char, NI_MAXHOST> host{};
    std::array<char, NI_MAXSERV> port{};
    ::getnameinfo(address.any(), address.size, host.data(), host.size(), port.data(), port.size(),
                  NI_NUMERICHOST | NI_NUMERICSERV);
    const std::string name(host.data());
    return fmt::format("http://{}:{}/",
                       address.storage.ss_family == AF_INET6 ? "[" + name + "]" : name,
                       port.data());
}

}  // namespace tribus::web
