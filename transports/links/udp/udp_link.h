#pragma once

#include <memory>
#include <string>

#include <tl/expected.hpp>

#include "core/setting.h"
#include "transports/links/link.h"
#include "transports/links/udp/udp_address.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// A UDP socket as a link of bytes: one datagram is one read, or one written frame. An input
/// receives from everybody who reaches its address; an output sends to its address, whether or not
/// somebody listens there. Thread-bound. No heap after `open`.
class UdpLink final : public ByteLink {
  public:
    /// `way` is input or output. `address` as in parse_udp_address. The error begins with the
    /// address and says what to do.
    static tl::expected<std::unique_ptr<UdpLink>, std::string> open(const std::string& address,
                                                                    SettingScope way);
    /// Whether no interface of this machine has the address: it may come later.
    static bool is_missing(const std::string& address);

    /// Reads one datagram. One that is longer than kBytesPerRead is read as no bytes. Never `lost`.
    ReadStatus read(Reception& reception) override;
    /// `busy` if the kernel has no room, `unavailable` if the network refuses the datagram.
    WriteStatus write(std::span<const std::uint8_t> frame) override;
    void discard_unread() override;
    int descriptor() const override { return fd_.get(); }

  private:
    UdpLink(UniqueFd fd, const UdpAddress& address) : fd_(std::move(fd)), address_(address) {}

    UniqueFd fd_;
    UdpAddress address_;
};

}  // namespace tribus
