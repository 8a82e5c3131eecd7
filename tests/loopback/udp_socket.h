#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <optional>

#include <gtest/gtest.h>

#include "tests/support/far_end.h"
#include "transports/links/unique_fd.h"

namespace tribus::test {

/// A UDP socket on this machine, with a port that the kernel chose.
class UdpSocket {
  public:
    UdpSocket() : fd_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
        sockaddr_in address = local(0);
        EXPECT_EQ(::bind(fd_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
        socklen_t size = sizeof address;
        ::getsockname(fd_.get(), reinterpret_cast<sockaddr*>(&address), &size);
        port_ = ntohs(address.sin_port);
    }
    std::uint16_t port() const { return port_; }
    void send_to(std::uint16_t port, const Bytes& bytes) const {
        const sockaddr_in address = local(port);
        ::sendto(fd_.get(), bytes.data(), bytes.size(), 0,
                 reinterpret_cast<const sockaddr*>(&address), sizeof address);
    }
    /// The next datagram, if one waits.
    std::optional<Bytes> receive() {
        Bytes bytes(1000);
        sockaddr_in from{};
        socklen_t size = sizeof from;
        const ssize_t length = ::recvfrom(fd_.get(), bytes.data(), bytes.size(), 0,
                                          reinterpret_cast<sockaddr*>(&from), &size);
        if (length < 0) {
            return std::nullopt;
        }
        bytes.resize(static_cast<std::size_t>(length));
        sender_ = ntohs(from.sin_port);
        return bytes;
    }
    /// The port that sent the latest datagram; 0 before.
    std::uint16_t sender() const { return sender_; }

  private:
    static sockaddr_in local(std::uint16_t port) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        return address;
    }
    UniqueFd fd_;
    std::uint16_t port_ = 0;
    std::uint16_t sender_ = 0;
};

inline std::uint16_t free_udp_port() {
    return UdpSocket().port();
}

}  // namespace tribus::test
