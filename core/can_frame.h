#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tribus {

/// Ids have 11 bits, or 29 in extended frames.
inline constexpr std::uint32_t kMostStandardId = 0x7FF;
inline constexpr std::uint32_t kMostExtendedId = 0x1FFF'FFFF;

inline constexpr std::size_t kMostClassicBytes = 8;
inline constexpr std::size_t kMostFdBytes = 64;

/// No snapshot of channels takes more CAN frames, in any format.
inline constexpr std::size_t kMostSnapshotFrames = 16;

/// The lengths that an FD frame can have beyond 8 bytes; a raw socket takes others without a word
/// (docs/protocols/can.md, "SocketCAN: sockets").
inline constexpr std::array<std::uint8_t, 7> kLongFdLengths{12, 16, 20, 24, 32, 48, 64};

constexpr bool valid_can_length(std::size_t length, bool fd) {
    return length <= kMostClassicBytes ||
           (fd && std::ranges::find(kLongFdLengths, length) != kLongFdLengths.end());
}

/// The shortest frame that holds so many bytes, at most 64.
constexpr std::size_t can_length_for(std::size_t bytes) {
    if (bytes <= kMostClassicBytes) {
        return bytes;
    }
    const auto* fit = std::ranges::lower_bound(kLongFdLengths, bytes);
    return fit == kLongFdLengths.end() ? kMostFdBytes : *fit;
}

/// One data or remote frame as the bus carries it. Trivially copyable.
struct CanFrame {
    std::uint32_t id = 0;  ///< without flags
    bool extended = false;
    bool remote = false;
    bool fd = false;
    bool bit_rate_switch = false;        ///< FD only
    bool error_state_indicator = false;  ///< FD only: its sender is error-passive
    std::uint8_t length = 0;
    std::array<std::uint8_t, kMostFdBytes> data{};

    std::span<const std::uint8_t> bytes() const { return {data.data(), length}; }
    std::span<std::uint8_t> bytes() { return {data.data(), length}; }
    bool operator==(const CanFrame&) const = default;
};

/// A set of ids: those whose bits under the mask are these. 11-bit and 29-bit ids are two worlds.
struct CanIdMatch {
    std::uint32_t id = 0;
    std::uint32_t mask = kMostExtendedId;
    bool extended = false;

    constexpr bool matches(const CanFrame& frame) const {
        return frame.extended == extended && ((frame.id ^ id) & mask) == 0;
    }
    constexpr bool overlaps(const CanIdMatch& other) const {
        return extended == other.extended && ((id ^ other.id) & mask & other.mask) == 0;
    }
    bool operator==(const CanIdMatch&) const = default;
};

}  // namespace tribus
