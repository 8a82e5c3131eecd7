#include "transports/links/udp/udp_address.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

namespace tribus {
namespace {

using WrongAddress = tl::unexpected<std::string>;

tl::expected<std::uint16_t, std::string> parse_port(std::string_view text) {
    std::uint16_t port = 0;
    const char* const behind = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), behind, port);
    const bool whole = error == std::errc() && end == behind;
    if (whole && port != 0) {
        return port;
    }
    const bool number = text.find_first_not_of("0123456789", text.starts_with('-') ? 1 : 0) ==
                        std::string_view::npos;
    return WrongAddress(text.empty() ? "the port is missing"
                        : number     ? "port " + std::string(text) + " is out of range"
                                     : "port " + std::string(text) + " is not a number");
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

bool is_for_all(const UdpAddress& address) {
    if (address.storage.ss_family == AF_INET) {
        return reinterpret_cast<const sockaddr_in*>(&address.storage)->sin_addr.s_addr ==
               htonl(INADDR_ANY);
    }
    return IN6_IS_ADDR_UNSPECIFIED(
        &reinterpret_cast<const sockaddr_in6*>(&address.storage)->sin6_addr);
}

}  // namespace

tl::expected<UdpAddress, std::string> parse_udp_address(const std::string& text) {
    const bool in_brackets = text.starts_with('[');
    const std::size_t colon = text.rfind(':');
    const bool version_6_digits =
        text.find_first_not_of("0123456789abcdefABCDEF:.") == std::string::npos;
    if (version_6_digits && std::ranges::count(text, ':') > 1) {
        return WrongAddress("an address of IP version 6 stands in brackets");
    }
    if (colon == std::string::npos || text.ends_with(']')) {
        return WrongAddress("the port is missing");
    }
    const auto port = parse_port(std::string_view(text).substr(colon + 1));
    if (!port) {
        return WrongAddress(port.error());
    }
    const std::string host = text.substr(0, colon);
    const bool closed = in_brackets && host.ends_with(']');
    const auto address =
        closed ? version_6(host.substr(1, host.size() - 2), *port) : version_4(host, *port);
    if (!address) {
        return WrongAddress(host + " is not an IP address in digits");
    }
    return *address;
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

bool is_delivered(const UdpAddress& to, const UdpAddress& at) {
    // The port has the same place in both versions.
    const auto port = [](const UdpAddress& address) {
        return reinterpret_cast<const sockaddr_in*>(&address.storage)->sin_port;
    };
    const bool here = to.loopback || is_for_all(to);
    // A socket of version 6 hears version 6 only (udp_link.cpp).
    return to.storage.ss_family == at.storage.ss_family && port(to) == port(at) &&
           (is_same_host(to, at) || (here && is_for_all(at)) || (is_for_all(to) && at.loopback));
}

}  // namespace tribus
