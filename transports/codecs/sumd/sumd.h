#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/codecs/codec.h"
#include "transports/codecs/framed_decoder.h"
#include "transports/codecs/protocol.h"

/// Graupner HoTT SUMD, both directions. A frame: A8, status, number of channels n (1 to 32), n
/// words of 1/8 us with the high byte first, CRC-16 of all before (polynomial 1021, start 0).
/// Status 01 (version 1) or 03 (version 3): the link is up; 81: failsafe. Sources: Betaflight
/// rx/sumd.c and its unit test, ArduPilot AP_RCProtocol_SUMD, PX4 sumd.c; a recording of a receiver
/// by PX4 (sumd_data.txt).
namespace tribus {

extern const Protocol kSumdProtocol;

/// Channels above kChannelCount are left out. A word of 0 is a channel that is not present, as
/// receivers send for unused ones. Channels stay in the order of the wire, where Graupner's senders
/// have the throttle first.
class SumdDecoder final : public FramedDecoder {
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const override;
    bool check_holds(std::span<const std::uint8_t> frame) const override;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;
};

/// Writes frames of version 1. An absent channel is sent as 0; pulses are limited to those with a
/// word, 1/8 us and above.
class SumdEncoder final : public ByteEncoder {
  public:
    /// `channels`: 1 to kChannelCount.
    explicit SumdEncoder(std::size_t channels) : channels_(channels) {}
    bool marks_frame_lost() const override { return false; }
    std::uint32_t needed_channels(const ChannelFrame& frame) const override;
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;

  private:
    std::size_t channels_;
};

}  // namespace tribus
