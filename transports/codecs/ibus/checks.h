#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/codecs/byte_sum.h"
#include "transports/codecs/ibus/ibus2_frame.h"
#include "transports/codecs/ibus/wire.h"

/// Checks that tell an i.Bus frame from noise; only for the decoder.
namespace tribus::ibus_checks {

using namespace ibus_wire;

inline constexpr std::uint8_t kIa6Header = 0x55;
inline constexpr std::size_t kIa6Length = 31;
inline constexpr std::size_t kIa6SlotsAt = 1;

// i-BUS2 is another protocol (docs/protocols/ibus2.md); its frames with at least one channel.
inline constexpr std::size_t kIbus2Shortest = 8;
inline constexpr std::size_t kIbus2Longest = ibus2_frame::kLongest;

static_assert(kIa6SlotsAt + 2 * kSlotCount + kChecksumBytes == kIa6Length);

inline std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t position) {
    return static_cast<std::uint16_t>(bytes[position] | bytes[position + 1] << 8);
}

inline constexpr std::uint16_t kLongFrameHeader = kLongestFrame | kServoCommand << 8U;

using byte_sums::sum_of;

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

constexpr bool is_servo_length(std::uint8_t first) {
    return first >= kShortestFrame && first <= kLongestFrame && first % 2 == 0;
}

constexpr bool may_be_ibus2(std::uint8_t first) {
    return ibus2_frame::type_of(first) == ibus2_frame::kToAll &&
           ibus2_frame::subtype_of(first) <= ibus2_frame::kLastSubtype;
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
