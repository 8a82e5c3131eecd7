#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>

#include "transports/codecs/ibus/wire.h"

/// Checks that tell an i.Bus frame from noise; only for the decoder.
namespace tribus::ibus_checks {

using namespace ibus_wire;

inline constexpr std::uint8_t kIa6Header = 0x55;
inline constexpr std::size_t kIa6Length = 31;
inline constexpr std::size_t kIa6SlotsAt = 1;

// i-BUS2 (AFHDS 3, another protocol; docs/protocols/ibus.md, "Variants"): bits 0 and 1 of the first
// byte are the packet type, 0 for channels; the next four its subtype, 0 to 2. The second byte is
// the length. The last byte is a CRC-8 with polynomial 0x25 and start value 0xFF. The start value
// is that of ArduPilot AP_IBus2 and its captures of a FTr8B; Betaflight has 0, which the captures
// refute.
inline constexpr std::uint8_t kIbus2TypeMask = 0x03;
inline constexpr unsigned kIbus2SubtypeShift = 2;
inline constexpr std::uint8_t kIbus2SubtypeMask = 0x0F;
inline constexpr std::uint8_t kIbus2LastSubtype = 2;
inline constexpr std::size_t kIbus2Shortest = 8;
inline constexpr std::size_t kIbus2Longest = 37;
inline constexpr std::uint8_t kIbus2Polynomial = 0x25;
inline constexpr std::uint8_t kIbus2CrcStart = 0xFF;

static_assert(kIa6SlotsAt + 2 * kSlotCount + kChecksumBytes == kIa6Length);

inline std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t position) {
    return static_cast<std::uint16_t>(bytes[position] | bytes[position + 1] << 8);
}

inline constexpr std::uint16_t kLongFrameHeader = kLongestFrame | kServoCommand << 8U;

/// Sum of at most 32 bytes.
inline unsigned sum_of(std::span<const std::uint8_t> bytes) {
    std::uint64_t words = 0;
    for (; bytes.size() >= kGroupBytes; bytes = bytes.subspan(kGroupBytes)) {
        words += sum_by_words(load_word(bytes.data()));
    }
    return std::accumulate(bytes.begin(), bytes.end(), total(words));
}

/// 0xFFFF less each byte before the checksum (docs/protocols/ibus.md, "Servo frame").
inline std::uint16_t servo_checksum(std::span<const std::uint8_t> body) {
    return static_cast<std::uint16_t>(0xFFFF - sum_of(body));
}

/// Whether the checksum of a frame of 32 bytes is correct. It is the upper quarter of the last
/// group.
inline bool long_frame_holds(std::span<const std::uint8_t, kLongestFrame> wire) {
    std::uint64_t words = 0;
    for (std::size_t at = 0; at < kLongestFrame - kGroupBytes; at += kGroupBytes) {
        words += sum_by_words(load_word(&wire[at]));
    }
    const std::uint64_t last = load_word(&wire[kLongestFrame - kGroupBytes]);
    words += sum_by_words(last & 0x0000FFFF'FFFFFFFF);
    return total(words) + (last >> 48U) == 0xFFFF;
}

/// Whether the checksum of a 0x55 frame is correct: the sum of the 14 words without the header
/// (docs/protocols/ibus.md, "Variants"). The plain sum is weak, so words above 12 bits, which are
/// no channel values, are refused too.
inline bool ia6_holds(std::span<const std::uint8_t> frame) {
    unsigned sum = 0;
    for (std::size_t slot = 0; slot < kSlotCount; ++slot) {
        const std::uint16_t word = word_at(frame, kIa6SlotsAt + 2 * slot);
        if (word > kChannelMask) {
            return false;
        }
        sum += word;
    }
    return (sum & 0xFFFFU) == word_at(frame, kIa6Length - kChecksumBytes);
}

/// Effect of a byte on the CRC of i-BUS2 when as many more bytes follow it as the index says.
using CrcTables = std::array<std::array<std::uint8_t, 256>, kGroupBytes>;
inline constexpr CrcTables kIbus2Crc = [] {
    CrcTables tables{};
    for (unsigned byte = 0; byte < 256; ++byte) {
        unsigned crc = byte;
        for (int bit = 0; bit < 8; ++bit) {
            crc = crc << 1U ^ ((crc & 0x80U) != 0 ? kIbus2Polynomial : 0U);
        }
        tables[0][byte] = static_cast<std::uint8_t>(crc);
    }
    for (std::size_t behind = 1; behind < tables.size(); ++behind) {
        for (std::size_t byte = 0; byte < 256; ++byte) {
            tables[behind][byte] = tables[0][tables[behind - 1][byte]];
        }
    }
    return tables;
}();

inline bool ibus2_holds(std::span<const std::uint8_t> frame) {
    std::uint8_t crc = kIbus2CrcStart;
    const std::uint8_t* at = frame.data();
    const std::uint8_t* const end = at + frame.size() - 1;
    const auto& crc_of = kIbus2Crc;
    for (; end - at >= 8; at += 8) {
        crc = crc_of[7][at[0] ^ crc] ^ crc_of[6][at[1]] ^ crc_of[5][at[2]] ^ crc_of[4][at[3]] ^
              crc_of[3][at[4]] ^ crc_of[2][at[5]] ^ crc_of[1][at[6]] ^ crc_of[0][at[7]];
    }
    if (end - at >= 4) {
        crc = crc_of[3][at[0] ^ crc] ^ crc_of[2][at[1]] ^ crc_of[1][at[2]] ^ crc_of[0][at[3]];
        at += 4;
    }
    for (; at != end; ++at) {
        crc = crc_of[0][*at ^ crc];
    }
    return crc == *end;
}

constexpr bool is_servo_length(std::uint8_t first) {
    return first >= kShortestFrame && first <= kLongestFrame && first % 2 == 0;
}

constexpr bool may_be_ibus2(std::uint8_t first) {
    return (first & kIbus2TypeMask) == 0 &&
           ((first >> kIbus2SubtypeShift) & kIbus2SubtypeMask) <= kIbus2LastSubtype;
}

// Frames that may begin with a byte, as bits.
inline constexpr std::uint8_t kServo = 1;
inline constexpr std::uint8_t kIa6 = 2;
inline constexpr std::uint8_t kIbus2Channels = 4;
inline constexpr auto kBegins = [] {
    std::array<std::uint8_t, 256> begins{};
    for (unsigned value = 0; value < begins.size(); ++value) {
        const auto first = static_cast<std::uint8_t>(value);
        begins[value] = static_cast<std::uint8_t>((is_servo_length(first) ? kServo : 0U) |
                                                  (first == kIa6Header ? kIa6 : 0U) |
                                                  (may_be_ibus2(first) ? kIbus2Channels : 0U));
    }
    return begins;
}();

inline bool is_servo_command(std::uint8_t first, std::uint8_t second) {
    return second == kServoCommand || (first == kLongestFrame && second == kBetaflightTestCommand);
}

}  // namespace tribus::ibus_checks
