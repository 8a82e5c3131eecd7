#pragma once

#include <sys/socket.h>

#include <string>

#include <tl/expected.hpp>

namespace tribus {

/// An IP address with a port, as sockets take it.
struct UdpAddress {
    sockaddr_storage storage{};
    socklen_t size = 0;
    /// Only programs on this machine reach it.
    bool loopback = false;

    const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
};

/// Reads `127.0.0.1:5501` or `[::1]:5501`: an address in digits and a port from 1 to 65535. Names
/// are not looked up, because that may block. The error says what is wrong with the text. Pure.
tl::expected<UdpAddress, std::string> parse_udp_address(const std::string& text);

/// Whether the IP addresses are the same, whatever the ports. Pure.
bool is_same_host(const UdpAddress& one, const UdpAddress& other);

/// Whether datagrams that this machine sends to `to` come to a socket of this machine at `at`: the
/// same port, and the same address or `at` for all addresses. An address of another machine may
/// only look so if `at` is for all addresses and `to` is neither that nor a loopback address; then
/// false. Pure.
bool is_delivered(const UdpAddress& to, const UdpAddress& at);

}  // namespace tribus
