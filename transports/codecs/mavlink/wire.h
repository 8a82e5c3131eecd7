#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/codecs/crc.h"

/// The frame of MAVLink (docs/protocols/mavlink.md, "Frame"). Pure and reentrant.
namespace tribus::mavlink_wire {

inline constexpr std::uint8_t kVersion1 = 0xFE;
inline constexpr std::uint8_t kVersion2 = 0xFD;
inline constexpr std::size_t kHeader1Bytes = 6;
inline constexpr std::size_t kHeader2Bytes = 10;
inline constexpr std::size_t kCrcBytes = 2;
// A signature: the id of the link, a time stamp, the beginning of a hash.
inline constexpr std::size_t kStampBytes = 6;
inline constexpr std::size_t kHashBytes = 6;
inline constexpr std::size_t kSignatureBytes = 1 + kStampBytes + kHashBytes;
/// Bits of the incompatibility flags. A frame with another one must not be read.
inline constexpr std::uint8_t kSignedFlag = 0x01;

/// A kind of message that tribus reads or writes.
struct MessageKind {
    std::uint32_t id = 0;
    /// Goes into the CRC: it tells whether both ends mean the same fields.
    std::uint8_t crc_extra = 0;
    /// Bytes of payload in version 1, which has no extension fields.
    std::uint8_t length_1 = 0;
    /// Bytes of payload with all fields.
    std::uint8_t length = 0;
};

// From common.xml, minimal.xml and development.xml of MAVLink; a test computes each CRC extra again
// from the fields.
inline constexpr MessageKind kHeartbeat{0, 50, 9, 9};
inline constexpr MessageKind kSysStatus{1, 124, 31, 43};
inline constexpr MessageKind kGpsRawInt{24, 24, 30, 52};
inline constexpr MessageKind kAttitude{30, 39, 28, 28};
inline constexpr MessageKind kRcChannels{65, 118, 42, 42};
inline constexpr MessageKind kManualControl{69, 243, 11, 30};
inline constexpr MessageKind kRcChannelsOverride{70, 124, 18, 38};
inline constexpr MessageKind kVfrHud{74, 20, 20, 20};
inline constexpr MessageKind kRadioStatus{109, 185, 9, 9};
inline constexpr MessageKind kBatteryStatus{147, 154, 36, 54};
inline constexpr MessageKind kRadioRcChannels{420, 20, 9, 73};

inline constexpr std::array kMessageKinds{
    kHeartbeat,          kSysStatus, kGpsRawInt,   kAttitude,      kRcChannels,     kManualControl,
    kRcChannelsOverride, kVfrHud,    kRadioStatus, kBatteryStatus, kRadioRcChannels};
inline constexpr std::size_t kMostPayload = kRadioRcChannels.length;

inline const MessageKind* find_kind(std::uint32_t id) {
    const auto* const found = std::ranges::find(kMessageKinds, id, &MessageKind::id);
    return found == kMessageKinds.end() ? nullptr : found;
}

/// CRC-16/MCRF4XX of all between the first byte and the CRC, and of the CRC extra.
inline std::uint16_t crc_of(std::span<const std::uint8_t> covered, std::uint8_t crc_extra) {
    using Check = Crc<std::uint16_t, 0x8408, CrcBits::lowest_first>;
    const std::uint16_t crc = Check::of(0xFFFF, covered);
    return Check::of_few(crc, std::span(&crc_extra, 1));
}

// Numbers in a payload, the low byte first.

template <class Number>
Number field_at(std::span<const std::uint8_t> payload, std::size_t at) {
    static_assert(sizeof(Number) <= sizeof(std::uint64_t));
    std::uint64_t bits = 0;
    for (std::size_t byte = 0; byte < sizeof(Number); ++byte) {
        bits |= std::uint64_t{payload[at + byte]} << (8 * byte);
    }
    if constexpr (sizeof(Number) == sizeof(std::uint32_t)) {
        return std::bit_cast<Number>(static_cast<std::uint32_t>(bits));
    } else {
        return static_cast<Number>(bits);
    }
}

template <class Number>
void put_field(std::span<std::uint8_t> payload, std::size_t at, Number number) {
    for (std::size_t byte = 0; byte < sizeof(Number); ++byte) {
        payload[at + byte] = static_cast<std::uint8_t>(number >> (8 * byte));
    }
}

/// MAV_COMP_ID_AUTOPILOT1: the component that is the vehicle's autopilot. Cameras, gimbals and
/// computers aboard send with its system id, and speak for themselves only.
inline constexpr std::uint8_t kAutopilotComponent = 1;

/// Where the channels of a message begin, and how many stand there.
struct ChannelPlace {
    std::size_t at = 0;
    std::size_t count = 0;
};
inline constexpr std::size_t kRcChannelsAt = 4;
inline constexpr std::size_t kRcCountAt = 40;
inline constexpr std::size_t kOverrideTargetAt = 16;
/// Channels 1 to 8, and 9 to 18.
inline constexpr ChannelPlace kOverrideFirst{0, 8};
inline constexpr ChannelPlace kOverrideMore{18, 10};
inline constexpr std::size_t override_at(std::size_t channel) {
    return channel < kOverrideFirst.count ? kOverrideFirst.at + 2 * channel
                                          : kOverrideMore.at + 2 * (channel - kOverrideFirst.count);
}
inline constexpr std::uint16_t kIgnored = 0xFFFF;
/// In a word of the first eight channels, and in one of the others.
inline constexpr std::uint16_t kReleasedFirst = 0;
inline constexpr std::uint16_t kReleasedMore = 0xFFFE;
inline constexpr std::size_t kHeartbeatTypeAt = 4;
inline constexpr std::size_t kHeartbeatAutopilotAt = 5;
inline constexpr std::size_t kRadioFlagsAt = 4;
inline constexpr std::size_t kRadioTargetAt = 6;
inline constexpr std::size_t kRadioCountAt = 8;
inline constexpr std::size_t kRadioChannelsAt = 9;
inline constexpr std::uint16_t kRadioFailsafe = 1;
inline constexpr std::uint16_t kRadioOutdated = 2;
inline constexpr std::size_t kManualPitchAt = 0;
inline constexpr std::size_t kManualRollAt = 2;
inline constexpr std::size_t kManualThrottleAt = 4;
inline constexpr std::size_t kManualYawAt = 6;
inline constexpr std::size_t kManualButtonsAt = 8;
inline constexpr std::size_t kManualTargetAt = 10;

}  // namespace tribus::mavlink_wire
