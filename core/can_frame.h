#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tribus {

/// Largest id of 11 bits, and of 29 bits (extended frames).
inline constexpr std::uint32_t kMostStandardId = 0x7FF;
inline constexpr std::uint32_t kMostExtendedId = 0x1FFF'FFFF;

inline constexpr std::size_t kMostClassicBytes = 8;
inline constexpr std::size_t kMostFdBytes = 64;

/// Upper limit of the CAN frames of one channel snapshot, in any format.
inline constexpr std::size_t kMostSnapshotFrames = 16;

/// Valid lengths of an FD frame above 8 bytes. A raw socket accepts other lengths without an error
/// (docs/protocols/can.md, "SocketCAN: sockets").
inline constexpr std::array<std::uint8_t, 7> kLongFdLengths{12, 16, 20, 24, 32, 48, 64};

/// Whether a classic or FD frame can have this length in bytes.
constexpr bool valid_can_length(std::size_t length, bool fd) {
    return length <= kMostClassicBytes ||
           (fd && std::ranges::find(kLongFdLengths, length) != kLongFdLengths.end());
}

/// Length of the shortest frame that holds `bytes`, at most 64.
constexpr std::size_t can_length_for(std::size_t bytes) {
    if (bytes <= kMostClassicBytes) {
        return bytes;
    }
    const auto* fit = std::ranges::lower_bound(kLongFdLengths, bytes);
    return fit == kLongFdLengths.end() ? kMostFdBytes : *fit;
}

/// One data or remote frame. Trivially copyable.
struct CanFrame {
    std::uint32_t id = 0;  ///< without flags
    bool extended = false;
    bool remote = false;
    bool fd = false;
    bool bit_rate_switch = false;        ///< FD only
    bool error_state_indicator = false;  ///< FD only: the sender is error-passive
    std::uint8_t length = 0;
    std::array<std::uint8_t, kMostFdBytes> data{};

    std::span<const std::uint8_t> bytes() const { return {data.data(), length}; }
    std::span<std::uint8_t> bytes() { return {data.data(), length}; }
    bool operator==(const CanFrame&) const = default;
};

/// An FD frame with these bytes, whose number is the length of a frame.
constexpr CanFrame fd_frame(std::uint32_t id, bool extended, std::span<const std::uint8_t> bytes) {
    CanFrame frame{.id = id,
                   .extended = extended,
                   .fd = true,
                   .bit_rate_switch = true,
                   .length = static_cast<std::uint8_t>(bytes.size())};
    std::ranges::copy(bytes, frame.data.begin());
    return frame;
}

/// A set of ids of one kind: those that equal `id` in the bits of `mask`. An 11-bit id never equals
/// a 29-bit id.
struct CanIdMatch {
    std::uint32_t id = 0;
    std::uint32_t mask = kMostExtendedId;
    bool extended = false;

    constexpr bool matches(const CanFrame& frame) const {
        return frame.extended == extended && ((frame.id ^ id) & mask) == 0;
    }
    /// Whether an id can be in both sets.
    constexpr bool overlaps(const CanIdMatch& other) const {
        return extended == other.extended && ((id ^ other.id) & mask & other.mask) == 0;
    }
    bool operator==(const CanIdMatch&) const = default;
};

}  // namespace tribus
