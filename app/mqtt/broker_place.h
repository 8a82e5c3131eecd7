#pragma once

#include <optional>
#include <string>

namespace tribus::mqtt {

/// Host and port of a broker.
struct BrokerPlace {
    std::string host;
    std::optional<int> port;  ///< absent: the usual one

    /// Only programs on this machine can be there.
    bool is_loopback() const;
};

/// Reads `HOST`, `HOST:PORT`, `[::1]:PORT`; HOST is a name or an address, PORT from 1 to 65535.
/// Nothing if it is none of them. Pure.
std::optional<BrokerPlace> parse_broker_place(const std::string& text);

}  // namespace tribus::mqtt
