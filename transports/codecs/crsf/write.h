#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/channel_frame.h"
#include "transports/codecs/crc8_d5.h"
#include "transports/codecs/crsf/wire.h"
#include "transports/codecs/sbus/packed_channels.h"
#include "transports/codecs/sbus/scale.h"

/// How frames of CRSF are written; only for its encoders.
namespace tribus::crsf_wire {

/// Writes all but the payload, which is there. Returns the length of the frame. Inlined, it costs
/// the encoder more instructions than the call.
template <std::size_t payload_bytes>
[[gnu::noinline]] std::size_t finish_frame(std::uint8_t address, std::uint8_t type,
                                           std::span<std::uint8_t> wire) {
    wire[0] = address;
    wire[kLengthAt] = static_cast<std::uint8_t>(payload_bytes + kTypeAndCheck);
    wire[kTypeAt] = type;
    constexpr std::size_t kCheckAt = kPayloadAt + payload_bytes;
    const std::span<const std::uint8_t> bytes = wire;
    wire[kCheckAt] = Crc8D5::of(0, bytes.subspan<kTypeAt, kCheckAt - kTypeAt>());
    return kCheckAt + 1;
}

/// Writes the channels; an absent one is 1500 us. Returns the length of the frame.
inline std::size_t write_channels(const ChannelFrame& frame, const SbusScale& scale,
                                  std::uint8_t address, std::span<std::uint8_t> wire) {
    SbusRaw raw;
    if (frame.has_first(kSbusChannels)) {
        raw = scale.encode_whole(frame);
    } else {
        ChannelFrame filled = frame;
        for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
            filled.set(channel, frame.channel_or(channel, kCentrePulse));
        }
        raw = scale.encode_whole(filled);
    }
    pack_channels(raw, 0, wire.subspan<kPayloadAt, kPackedChannelBytes + 1>());
    return finish_frame<kPackedChannelBytes>(address, kChannelsType, wire);
}

}  // namespace tribus::crsf_wire
