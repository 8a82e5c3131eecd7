#include "transports/links/udp/udp_link.h"

#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace tribus {
namespace {

/// Room for some 40 small datagrams, of which each takes about 800 bytes of kernel memory: a third
/// of a second of frames. Older ones are worth nothing.
constexpr int kReceiveBufferBytes = 16 * 1024;
constexpr int kMostDiscarded = 256;
/// DSCP 46, "expedited forwarding" (RFC 3246), in the upper six bits.
constexpr int kExpedited = 46 << 2;
/// Ports below need a privilege.
constexpr const char* kPrivileged =
    "ports below 1024 need a privilege; choose another port, such as 5501";

std::string bind_problem(int error) {
    switch (error) {
        case EADDRINUSE:
            return "another program receives there; stop it, or choose another port";
        case EADDRNOTAVAIL:
            return "no interface of this machine has this address now; `ip -brief address` lists "
                   "them";
        case EACCES:
            return kPrivileged;
        default:
            return std::string("cannot receive there: ") + std::strerror(error);
    }
}

UniqueFd socket_for(const UdpAddress& address) {
    const int type = SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC;
    UniqueFd fd(::socket(address.storage.ss_family, type, 0));
    constexpr int kOn = 1;
    if (fd.valid() && address.storage.ss_family == AF_INET6) {
        ::setsockopt(fd.get(), IPPROTO_IPV6, IPV6_V6ONLY, &kOn, sizeof kOn);
        ::setsockopt(fd.get(), IPPROTO_IPV6, IPV6_TCLASS, &kExpedited, sizeof kExpedited);
    } else if (fd.valid()) {
        ::setsockopt(fd.get(), IPPROTO_IP, IP_TOS, &kExpedited, sizeof kExpedited);
    }
    return fd;
}

}  // namespace

tl::expected<std::unique_ptr<UdpLink>, std::string> UdpLink::open(const std::string& address,
                                                                  SettingScope way,
                                                                  const std::string& sender) {
    const auto failed = [&address](const std::string& why) {
        return tl::unexpected(address + ": " + why);
    };
    const auto parsed = parse_udp_address(address);
    if (!parsed) {
        return failed(parsed.error() + "; give an address with a port, such as 127.0.0.1:5501");
    }
    UniqueFd fd = socket_for(*parsed);
    if (!fd.valid()) {
        return failed(errno == EAFNOSUPPORT
                          ? std::string("this program may not use the network; for a service see "
                                        "/usr/share/doc/tribus/docs/service.md, \"UDP in the "
                                        "service\"")
                          : std::string("cannot make a socket: ") + std::strerror(errno));
    }
    if (way == SettingScope::input) {
        ::setsockopt(fd.get(), SOL_SOCKET, SO_RCVBUF, &kReceiveBufferBytes,
                     sizeof kReceiveBufferBytes);
        if (::bind(fd.get(), parsed->get(), parsed->size) != 0) {
            return failed(bind_problem(errno));
        }
    }
    const auto from = parse_udp_address(sender + ":1");
    if (!sender.empty() && !from) {
        return failed("\"" + sender + "\" is not an IP address");
    }
    return std::unique_ptr<UdpLink>(
        new UdpLink(std::move(fd), way == SettingScope::input ? UdpAddress{} : *parsed,
                    sender.empty() ? std::nullopt : std::optional(*from)));
}

bool UdpLink::is_missing(const std::string& address) {
    const std::size_t colon = address.rfind(':');
    // Port 0, which parse_udp_address refuses, lets the kernel choose one.
    auto any_port = parse_udp_address(address.substr(0, colon) + ":1");
    if (!any_port) {
        return false;
    }
    auto* const port_4 = reinterpret_cast<sockaddr_in*>(&any_port->storage);
    port_4->sin_port = 0;  // the same place in both versions
    static_assert(offsetof(sockaddr_in, sin_port) == offsetof(sockaddr_in6, sin6_port));
    const UniqueFd fd = socket_for(*any_port);
    return fd.valid() && ::bind(fd.get(), any_port->get(), any_port->size) != 0 &&
           errno == EADDRNOTAVAIL;
}

/// Receives one datagram. Returns false if none waits.
bool UdpLink::receive() {
    UdpAddress from;
    from.size = sizeof from.storage;
    const ssize_t length = ::recvfrom(fd_.get(), datagram_.data(), datagram_.size(), MSG_TRUNC,
                                      reinterpret_cast<sockaddr*>(&from.storage), &from.size);
    if (length == -1) {
        return false;
    }
    const auto bytes = static_cast<std::size_t>(length);
    const bool wanted = !sender_ || is_same_host(from, *sender_);
    unread_ = std::span(datagram_).first(wanted && bytes <= datagram_.size() ? bytes : 0);
    if (answers_ && !unread_.empty()) {
        peer_ = from;
    }
    return true;
}

ReadStatus UdpLink::read(Reception& reception) {
    reception.damaged.reset();
    reception.count = 0;
    reception.full = false;
    reception.goes_on = false;
    if (unread_.empty() && !receive()) {
        return ReadStatus::nothing;
    }
    reception.count = std::min(unread_.size(), reception.bytes.size());
    std::copy_n(unread_.begin(), reception.count, reception.bytes.begin());
    unread_ = unread_.subspan(reception.count);
    reception.full = true;
    reception.goes_on = !unread_.empty();
    return ReadStatus::received;
}

WriteStatus UdpLink::write(std::span<const std::uint8_t> frame) {
    if (peer_.size == 0) {
        return WriteStatus::unavailable;
    }
    const ssize_t sent =
        ::sendto(fd_.get(), frame.data(), frame.size(), MSG_NOSIGNAL, peer_.get(), peer_.size);
    if (sent >= 0) {
        return WriteStatus::written;
    }
    const bool no_room = errno == EAGAIN || errno == ENOBUFS || errno == EINTR;
    return no_room ? WriteStatus::busy : WriteStatus::unavailable;
}

void UdpLink::discard_unread() {
    unread_ = {};
    std::uint8_t byte = 0;
    for (int i = 0; i < kMostDiscarded; ++i) {
        if (::recv(fd_.get(), &byte, sizeof byte, MSG_TRUNC) == -1) {
            return;
        }
    }
}

}  // namespace tribus
