#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/line_settings.h"
#include "core/setting.h"
#include "transports/codecs/crc.h"

/// Bytes of Jeti EX Bus (docs/protocols/exbus.md, "Frame"), for its decoder and its encoder.
namespace tribus {

inline constexpr std::uint8_t kExBusFromReceiver = 0x3E;
inline constexpr std::uint8_t kExBusRequest = 0x3D;
inline constexpr std::uint8_t kExBusAnswer = 0x3B;
inline constexpr std::uint8_t kExBusAnswerAllowed = 0x01;
inline constexpr std::uint8_t kExBusAnswerForbidden = 0x03;
inline constexpr std::uint8_t kExBusChannels = 0x31;
inline constexpr std::uint8_t kExBusTelemetry = 0x3A;
inline constexpr std::size_t kExBusAccessAt = 1;
inline constexpr std::size_t kExBusLengthAt = 2;
inline constexpr std::size_t kExBusPacketAt = 3;
inline constexpr std::size_t kExBusKindAt = 4;
inline constexpr std::size_t kExBusDataLengthAt = 5;
inline constexpr std::size_t kExBusDataAt = 6;
inline constexpr std::size_t kExBusCheckBytes = 2;
inline constexpr std::size_t kExBusLeastLength = kExBusDataAt + kExBusCheckBytes;
/// No known frame is longer than the 56 bytes of 24 channels.
inline constexpr std::size_t kExBusMostLength = 64;
inline constexpr std::size_t kExBusMostWireChannels = 24;
static_assert(kExBusLeastLength + 2 * kExBusMostWireChannels <= kExBusMostLength);

/// The check of a frame: the lowest bit first, polynomial 1021, which is 8408 in that order, start
/// 0. The low byte is sent first.
using ExBusCrc = Crc<std::uint16_t, 0x8408, CrcBits::lowest_first>;

inline constexpr LineSettings kExBusLine{.baud = 125000, .parity = Parity::none, .stop_bits = 1};
inline constexpr std::array<std::string_view, 2> kExBusBaudChoices{"125000", "250000"};
inline constexpr Setting kExBusBaudSetting{
    .key = "baud",
    .type = SettingType::integer,
    .fallback = "125000",
    .unit = "baud",
    .choices = kExBusBaudChoices,
    .of_line = true,
    .help = "Bit rate of the line: 125000, or 250000 for EX Bus HS",
    .example = "250000"};

}  // namespace tribus
