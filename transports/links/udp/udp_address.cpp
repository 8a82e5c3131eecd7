#include "transports/links/udp/udp_address.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <charconv>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace tribus {
namespace {

std::optional<std::uint16_t> parse_port(std::string_view text) {
    std::uint16_t port = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
    const bool whole = error == std::errc() && end == text.data() + text.size();
    return whole && port != 0 ? std::optional(port) : std::nullopt;
}

template <class Address>
UdpAddress stored(const Address& address, bool loopback) {
    UdpAddress stored{.size = sizeof address, .loopback = loopback};
    std::memcpy(&stored.storage, &address, sizeof address);
    return stored;
}

std::optional<UdpAddress> version_4(const std::string& host, std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    if (::inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1) {
        return std::nullopt;
    }
    constexpr unsigned kFirstByte = 24;
    return stored(address, ntohl(address.sin_addr.s_addr) >> kFirstByte == IN_LOOPBACKNET);
}

std::optional<UdpAddress> version_6(const std::string& host, std::uint16_t port) {
    sockaddr_in6 address{};
    address.sin6_family = AF_INET6;
    address.sin6_port = htons(port);
    if (::inet_pton(AF_INET6, host.c_str(), &address.sin6_addr) != 1) {
        return std::nullopt;
    }
    return stored(address,
                  std::memcmp(&address.sin6_addr, &in6addr_loopback, sizeof in6addr_loopback) == 0);
}

}  // namespace

std::optional<UdpAddress> parse_udp_address(const std::string& text) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos) {
        return std::nullopt;
    }
    const auto port = parse_port(std::string_view(text).substr(colon + 1));
    const std::string host = text.substr(0, colon);
    if (!port) {
        return std::nullopt;
    }
    if (host.starts_with('[') && host.ends_with(']')) {
        return version_6(host.substr(1, host.size() - 2), *port);
    }
    return version_4(host, *port);
}

bool is_same_host(const UdpAddress& one, const UdpAddress& other) {
    if (one.storage.ss_family != other.storage.ss_family) {
        return false;
    }
    if (one.storage.ss_family == AF_INET) {
        return reinterpret_cast<const sockaddr_in*>(&one.storage)->sin_addr.s_addr ==
               reinterpret_cast<const sockaddr_in*>(&other.storage)->sin_addr.s_addr;
    }
    return std::memcmp(&reinterpret_cast<const sockaddr_in6*>(&one.storage)->sin6_addr,
                       &reinterpret_cast<const sockaddr_in6*>(&other.storage)->sin6_addr,
                       sizeof(in6_addr)) == 0;
}

}  // namespace tribus
