#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/channel_frame.h"
#include "transports/codecs/crc8_d5.h"
#include "transports/codecs/crsf/wire.h"
#include "transports/codecs/sbus/packed_channels.h"
#include "transports/codecs/sbus/scale.h"
#include "transports/codecs/wire_words.h"

/// How frames of CRSF are written; only for its encoders.
namespace tribus::crsf_wire {

/// Writes all but the payload, which is there. Returns the length of the frame.
template <std::size_t payload_bytes>
std::size_t finish_frame(std::uint8_t address, std::uint8_t type, std::span<std::uint8_t> wire) {
    wire[0] = address;
    wire[kLengthAt] = static_cast<std::uint8_t>(payload_bytes + kTypeAndCheck);
    wire[kTypeAt] = type;
    constexpr std::size_t kCheckAt = kPayloadAt + payload_bytes;
    const std::span<const std::uint8_t> bytes = wire;
    wire[kCheckAt] = Crc8D5::of(0, bytes.subspan<kTypeAt, kCheckAt - kTypeAt>());
    return kCheckAt + 1;
}

/// Writes channels that are all present. Returns the length of the frame.
inline std::size_t write_present_channels(const ChannelFrame& frame, const SbusScale& scale,
                                          std::uint8_t address, std::span<std::uint8_t> wire) {
    constexpr std::size_t kCheckAt = kChannelsFrameBytes - 1;
    store_half_word(wire.data(), channels_head(address));
    pack_channels(scale.encode_whole(frame), 0,
                  wire.subspan<kPayloadAt, kPackedChannelBytes + 1>());
    const std::span<const std::uint8_t> bytes = wire;
    wire[kCheckAt] = crc8_d5_remainder(bytes.subspan<kTypeAt, kCrc8D5FoldedBytes>());
    return kChannelsFrameBytes;
}

inline std::size_t write_centred_channels(const ChannelFrame& frame, const SbusScale& scale,
                                          std::uint8_t address, std::span<std::uint8_t> wire) {
    ChannelFrame filled = frame;
    for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
        filled.set(channel, frame.channel_or(channel, kCentrePulse));
    }
    return write_present_channels(filled, scale, address, wire);
}

/// Writes the channels; an absent one is 1500 us. Returns the length of the frame.
inline std::size_t write_channels(const ChannelFrame& frame, const SbusScale& scale,
                                  std::uint8_t address, std::span<std::uint8_t> wire) {
    return frame.has_first(kSbusChannels) ? write_present_channels(frame, scale, address, wire)
                                          : write_centred_channels(frame, scale, address, wire);
}

}  // namespace tribus::crsf_wire
