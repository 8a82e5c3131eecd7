#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/codecs/codec.h"
#include "transports/codecs/protocol.h"

/// RC input of ArduPilot's simulator SITL, over UDP (docs/protocols/sitl.md). A datagram: 8 or 16
/// words, a channel each, whole microseconds, the low byte first; nothing else.
namespace tribus {

extern const Protocol kSitlProtocol;

/// Every channel has a pulse, to the next whole microsecond: the simulator reads 0 as "keep the
/// value before". On loss nothing is sent.
class SitlEncoder final : public ByteEncoder {
  public:
    /// `channels`: 8 or 16.
    explicit SitlEncoder(std::size_t channels) : channels_(channels) {}
    bool marks_frame_lost() const override { return false; }
    std::uint32_t needed_channels(const ChannelFrame& frame) const override;
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;

  private:
    std::size_t channels_;
};

}  // namespace tribus
