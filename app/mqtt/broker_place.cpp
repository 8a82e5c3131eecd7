#include "app/mqtt/broker_place.h"

#include <algorithm>
#include <charconv>
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

bool BrokerPlace::is_loopback() const {
    return host == "localhost" || host == "::1" || host.starts_with("127.");
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
