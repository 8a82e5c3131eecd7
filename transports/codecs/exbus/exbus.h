#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/channel_frame.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/framed_decoder.h"
#include "transports/codecs/protocol.h"

/// Jeti EX Bus, channels only (docs/protocols/exbus.md). A frame: 3E (channels), 3D (request) or 3B
/// (answer), 01 or 03, length of the whole frame, packet number, kind of data, length of the data,
/// data, CRC-16. Sources: examples of Jeti's text (EX Bus protocol 1.21) as oXs_on_RP2040 repeats
/// them, Betaflight rx/jetiexbus.c.
namespace tribus {

extern const Protocol kExBusProtocol;

/// Finds frames of any kind with a right check, up to 64 bytes.
class ExBusFrames : public FramedDecoder {
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const final;
    bool check_holds(std::span<const std::uint8_t> frame) const final;
};

/// Reads frames of channels, and passes over requests and answers on the same wire. A word is a
/// pulse in 1/8 us, the low byte first; up to 24, of which the first kChannelCount are used. A word
/// of 0, or of 4096 us and more, is no pulse: the channel is absent. Nothing says failsafe.
/// Channels stay in the order of the wire.
class ExBusDecoder final : public ExBusFrames {
    Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                 DecodedFrame& frame) override;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;
};

}  // namespace tribus
