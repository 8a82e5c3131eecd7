#pragma once

#include <cstddef>
#include <cstdint>

#include "transports/codecs/sbus/packed_channels.h"
#include "transports/codecs/sbus/scale.h"

/// Layout of CRSF frames (docs/protocols/crsf.md, "Frame"); only for its decoder and encoder.
namespace tribus::crsf_wire {

inline constexpr std::size_t kLengthAt = 1;
inline constexpr std::size_t kTypeAt = 2;
inline constexpr std::size_t kPayloadAt = 3;
/// Bytes of a frame beside those that its length counts: address and length.
inline constexpr std::size_t kUncounted = 2;
/// Counted bytes beside the payload: type and CRC.
inline constexpr std::size_t kTypeAndCheck = 2;
inline constexpr std::size_t kLeastLength = kTypeAndCheck;
inline constexpr std::size_t kMostLength = 62;

/// The address that every reader of a receiver's frames takes.
inline constexpr std::uint8_t kFlightController = 0xC8;
inline constexpr std::uint8_t kHandset = 0xEA;
inline constexpr std::uint8_t kTransmitter = 0xEE;

/// Whether frames may begin with this byte. Senders put the receiver's address or theirs.
constexpr bool is_address(std::uint8_t byte) {
    constexpr std::uint8_t kBroadcast = 0x00;
    constexpr std::uint8_t kReceiver = 0xEC;
    return byte == kFlightController || byte == kBroadcast || byte == kHandset ||
           byte == kReceiver || byte == kTransmitter;
}

inline constexpr std::uint8_t kStatisticsType = 0x14;
inline constexpr std::uint8_t kChannelsType = 0x16;
inline constexpr std::uint8_t kSubsetType = 0x17;
inline constexpr std::uint8_t kReceiverStatisticsType = 0x1C;

inline constexpr std::size_t kStatisticsBytes = 10;
inline constexpr std::size_t kReceiverStatisticsBytes = 5;
inline constexpr std::size_t kChannelsFrameBytes = kPayloadAt + kPackedChannelBytes + 1;
/// Address, length and type of the usual frame of channels, the first byte lowest.
inline constexpr std::uint32_t kHeadBits = 0x00FF'FFFF;
constexpr std::uint32_t channels_head(std::uint8_t address) {
    return address | (kPackedChannelBytes + kTypeAndCheck) << 8U * kLengthAt |
           std::uint32_t{kChannelsType} << 8U * kTypeAt;
}
inline constexpr std::size_t kStatisticsFrameBytes = kPayloadAt + kStatisticsBytes + 1;

/// Least payload of a type that is read; 0 for others.
constexpr std::size_t least_payload(std::uint8_t type) {
    switch (type) {
        case kChannelsType:
            return kPackedChannelBytes;
        case kStatisticsType:
            return kStatisticsBytes;
        case kReceiverStatisticsType:
            return kReceiverStatisticsBytes;
        case kSubsetType:
            return 2;
        default:
            return 0;
    }
}

}  // namespace tribus::crsf_wire
