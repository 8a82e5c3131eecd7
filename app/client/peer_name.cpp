#include "app/client/peer_name.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>

#include <fmt/format.h>

namespace tribus {
namespace {

std::string peer_name_of(const in_addr& address) {
    std::array<char, INET_ADDRSTRLEN> text{};
    ::inet_ntop(AF_INET, &address, text.data(), text.size());
    return text.data();
}

std::string peer_name_of(in6_addr address) {
    constexpr std::size_t kV4At = 12;
    constexpr std::size_t kNetworkBytes = 8;
    if (IN6_IS_ADDR_V4MAPPED(&address)) {
        in_addr v4{};
        std::copy(std::begin(address.s6_addr) + kV4At, std::end(address.s6_addr),
                  reinterpret_cast<std::uint8_t*>(&v4));
        return peer_name_of(v4);
    }
    const bool is_network = !IN6_IS_ADDR_LOOPBACK(&address);
    if (is_network) {
        std::fill(std::begin(address.s6_addr) + kNetworkBytes, std::end(address.s6_addr), 0);
    }
    std::array<char, INET6_ADDRSTRLEN> text{};
    ::inet_ntop(AF_INET6, &address, text.data(), text.size());
    return std::string(text.data()) + (is_network ? "/64" : "");
}

}  // namespace

std::string peer_name(int descriptor) {
    union {
        sockaddr any;
        sockaddr_in v4;
        sockaddr_in6 v6;
    } peer{};
    socklen_t size = sizeof peer;
    ::getpeername(descriptor, &peer.any, &size);
    if (peer.any.sa_family == AF_INET) {
        return peer_name_of(peer.v4.sin_addr);
    }
    if (peer.any.sa_family == AF_INET6) {
        return peer_name_of(peer.v6.sin6_addr);
    }
    ucred user{};
    size = sizeof user;
    ::getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &user, &size);
    return fmt::format("user {}", user.uid);
}

std::optional<std::string> peer_name(const std::string& address) {
    in_addr v4{};
    in6_addr v6{};
    return ::inet_pton(AF_INET, address.c_str(), &v4) == 1    ? std::optional(peer_name_of(v4))
           : ::inet_pton(AF_INET6, address.c_str(), &v6) == 1 ? std::optional(peer_name_of(v6))
                                                              : std::nullopt;
}

bool is_on_this_machine(const std::string& name) {
    return name.starts_with("user ") || name.starts_with("127.") || name == "::1";
}

}  // namespace tribus
