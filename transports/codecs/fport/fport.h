#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/fport/channels.h"
#include "transports/codecs/framed_decoder.h"
#include "transports/codecs/protocol.h"
#include "transports/codecs/sbus/scale.h"

/// FrSky F.Port, F.Port 2 and FBUS, as input (docs/protocols/fport.md): channels in the form of
/// SBUS and telemetry on one wire, with a checksum.
namespace tribus {

extern const Protocol kFportProtocol;
extern const Protocol kFport2Protocol;
/// F.Port 2 at 460800 baud.
extern const Protocol kFbusProtocol;

/// Reads frames with 16 channels. They lie between markers 7E; inside of a frame 7E and 7D are
/// escaped. Passes over requests for telemetry, and over replies, which have no markers.
class FportDecoder final : public FramedDecoder {
  public:
    explicit FportDecoder(SbusScale scale = *SbusScale::named("betaflight")) : channels_(scale) {}
    std::span<const FrameDetail> details() const override { return channels_.details(); }

  private:
    Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                 DecodedFrame& frame) override;
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const override;
    bool check_holds(std::span<const std::uint8_t> frame) const override;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;

    FportChannels channels_;
};

/// Reads frames with 8, 16 or 24 channels, of which the first kChannelCount are used. Passes over
/// telemetry, requests and replies, and over updates of a device's program.
class Fport2Decoder final : public FramedDecoder {
  public:
    explicit Fport2Decoder(SbusScale scale = *SbusScale::named("betaflight")) : channels_(scale) {}
    std::span<const FrameDetail> details() const override { return channels_.details(); }

  private:
    Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                 DecodedFrame& frame) override;
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const override;
    bool check_holds(std::span<const std::uint8_t> frame) const override;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;

    FportChannels channels_;
};

}  // namespace tribus
