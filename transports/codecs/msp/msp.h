#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/codecs/codec.h"
#include "transports/codecs/framed_decoder.h"
#include "transports/codecs/protocol.h"

/// MSP, the protocol of flight controllers with Betaflight or INAV on USB and on UARTs: its command
/// MSP_SET_RAW_RC (docs/protocols/msp.md). A message of version 1: "$M<", number of bytes of
/// content, command, content, XOR of all behind "<". Of version 2: "$X<", flag, command and number
/// of bytes of content as words, content, CRC-8 of all behind "<". The content of MSP_SET_RAW_RC is
/// one word a channel, whole microseconds. Words have the low byte first.
namespace tribus {

extern const Protocol kMspProtocol;

/// Reads both versions. Passes over other commands and over answers. A word of 0, or above 4095, is
/// a channel that is not present. Nothing in MSP says failsafe: a sender that has lost its source
/// is silent.
class MspDecoder final : public FramedDecoder {
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const override;
    bool check_holds(std::span<const std::uint8_t> frame) const override;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;
};

/// Writes version 1. Every channel has a pulse, to the next whole microsecond: MSP has no word for
/// an absent channel. On loss nothing is sent.
class MspEncoder final : public ByteEncoder {
  public:
    /// `channels`: 1 to kChannelCount.
    explicit MspEncoder(std::size_t channels) : channels_(channels) {}
    bool marks_frame_lost() const override { return false; }
    std::uint32_t needed_channels(const ChannelFrame& frame) const override;
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;

  private:
    std::size_t channels_;
};

}  // namespace tribus
