#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/codecs/crc.h"

/// Beginning and check of i-BUS2 frames (docs/protocols/ibus2.md, "Frames"), for its decoder and
/// for that of i.Bus, which tells such a line from its own.
namespace tribus::ibus2_frame {

/// Bits 0 and 1 of the first byte.
inline constexpr std::uint8_t kTypeMask = 0x03;
/// For all devices: channels or what they need to be read. The next four bits are a subtype, and
/// the second byte is the length.
inline constexpr std::uint8_t kToAll = 0;
inline constexpr unsigned kSubtypeShift = 2;
inline constexpr std::uint8_t kSubtypeMask = 0x0F;
inline constexpr std::uint8_t kLastSubtype = 2;
inline constexpr std::size_t kLongest = 37;

constexpr std::uint8_t type_of(std::uint8_t first) {
    return first & kTypeMask;
}
constexpr std::uint8_t subtype_of(std::uint8_t first) {
    return static_cast<std::uint8_t>((first >> kSubtypeShift) & kSubtypeMask);
}

/// The CRC-8 with which a frame ends: polynomial 0x25, start value 0xFF. That of a whole frame is
/// 0. The start value is that of ArduPilot AP_IBus2 and its captures of a FTr8B; Betaflight has 0,
/// which the captures refute.
inline std::uint8_t crc_of(std::span<const std::uint8_t> bytes) {
    return Crc<std::uint8_t, 0x25>::of(0xFF, bytes);
}

}  // namespace tribus::ibus2_frame
