#include "app/mqtt/broker_place.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace tribus::mqtt {
namespace {

constexpr int kMostPort = 65535;

std::optional<int> port_of(std::string_view text) {
    int port = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
    const bool whole = error == std::errc() && end == text.data() + text.size();
    return whole && port >= 1 && port <= kMostPort ? std::optional(port) : std::nullopt;
}

bool is_host(std::string_view text) {
    return !text.empty() && std::ranges::none_of(text, [](char c) {
        return c == '/' || c == '@' || c == ' ' || static_cast<unsigned char>(c) < ' ';
    });
}

}  // namespace

/// Only an address says where it leads: a name such as 127.example.org may lead anywhere.
bool BrokerPlace::is_loopback() const {
    constexpr std::uint8_t kLoopbackNet = 127;
    std::array<std::uint8_t, sizeof(in_addr)> v4{};
    if (::inet_pton(AF_INET, host.c_str(), v4.data()) == 1) {
        return v4.front() == kLoopbackNet;
    }
    in6_addr v6{};
    return host == "localhost" || (::inet_pton(AF_INET6, host.c_str(), &v6) == 1 &&
                                   std::memcmp(&v6, &in6addr_loopback, sizeof v6) == 0);
}

std::optional<BrokerPlace> parse_broker_place(const std::string& text) {
    const bool in_brackets = text.starts_with('[');
    const std::size_t host_end = in_brackets ? text.find(']') : text.find(':');
    if (in_brackets && host_end == std::string::npos) {
        return std::nullopt;
    }
    BrokerPlace place{.host = in_brackets ? text.substr(1, host_end - 1) : text.substr(0, host_end),
                      .port = {}};
    const std::size_t rest = in_brackets ? host_end + 1 : host_end;
    if (rest < text.size()) {
        place.port =
            text[rest] == ':' ? port_of(std::string_view(text).substr(rest + 1)) : std::nullopt;
        if (!place.port) {
            return std::nullopt;
        }
    }
    return is_host(place.host) ? std::optional(std::move(place)) : std::nullopt;
}

}  // namespace tribus::mqtt
