#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <tl/expected.hpp>

#include "core/setting.h"
#include "transports/links/link.h"
#include "transports/links/udp/udp_address.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// A UDP socket as a link of bytes: one datagram is one written frame, and one read, or more if it
/// is long. An input receives from everybody who reaches its address, or from one sender only; an
/// output sends to its address, whether or not somebody listens there. Its datagrams are marked as
/// those that must not wait (DSCP EF, RFC 3246). Thread-bound. No heap after `open`.
class UdpLink final : public ByteLink {
  public:
    /// Longer datagrams are read as no bytes.
    static constexpr std::size_t kLongestDatagram = 2048;

    /// `way` is input or output. `address` as in parse_udp_address. `sender`: the IP address whose
    /// datagrams an input reads, without a port; empty: everybody's. The error begins with the
    /// address and says what to do.
    static tl::expected<std::unique_ptr<UdpLink>, std::string> open(const std::string& address,
                                                                    SettingScope way,
                                                                    const std::string& sender = {});
    /// Whether no interface of this machine has the address: it may come later.
    static bool is_missing(const std::string& address);

    /// Reads one datagram, or the next part of one. Never `lost`.
    ReadStatus read(Reception& reception) override;
    /// An input sends to whom its latest datagram came from. `busy` if the kernel has no room,
    /// `unavailable` if the network refuses the datagram, or if nobody is known yet.
    WriteStatus write(std::span<const std::uint8_t> frame) override;
    void discard_unread() override;
    int descriptor() const override { return fd_.get(); }

  private:
    UdpLink(UniqueFd fd, const UdpAddress& peer, const std::optional<UdpAddress>& sender)
        : fd_(std::move(fd)), peer_(peer), answers_(peer.size == 0), sender_(sender) {}
    bool receive();

    UniqueFd fd_;
    /// Of an output: its address. Of an input: whom its latest datagram came from; of size 0
    /// before.
    UdpAddress peer_;
    bool answers_;  ///< sends to whom it hears
    std::optional<UdpAddress> sender_;
    /// The latest datagram, and the part of it that is not read yet.
    std::array<std::uint8_t, kLongestDatagram> datagram_{};
    std::span<const std::uint8_t> unread_;
};

}  // namespace tribus
