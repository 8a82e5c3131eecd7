#pragma once

#include <optional>
#include <string>

/// Names of clients, to share places and pauses among them fairly: "user 1000" of a local socket,
/// else an IPv4 address, or the network of an IPv6 address, "2001:db8:1:2::/64", because one client
/// can have all addresses of it.
namespace tribus {

/// The name of the other side of a socket.
std::string peer_name(int descriptor);
/// The name for an address that is written as text. Nothing: it is none.
std::optional<std::string> peer_name(const std::string& address);
/// Whether the name is of this machine: a local socket or a loopback address.
bool is_on_this_machine(const std::string& name);

}  // namespace tribus
