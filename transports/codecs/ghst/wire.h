#pragma once

#include <cstddef>
#include <cstdint>

/// Layout of GHST frames (docs/protocols/ghst.md, "Frame"); only for its decoder and encoder.
namespace tribus::ghst_wire {

/// Address of a flight controller, to which receivers send.
inline constexpr std::uint8_t kGhstAddress = 0x82;
/// Length of the rest: type, payload, CRC. No frame of channels has another one.
inline constexpr std::uint8_t kGhstLength = 12;

inline constexpr std::size_t kGhstLengthAt = 1;
inline constexpr std::size_t kGhstTypeAt = 2;
/// Four channels of 12 bits, the lowest bit first, then four bytes.
inline constexpr std::size_t kGhstFineAt = 3;
inline constexpr std::size_t kGhstCoarseAt = 9;
inline constexpr std::size_t kGhstCheckAt = 13;
inline constexpr std::size_t kGhstFrameBytes = 14;
inline constexpr std::size_t kGhstCheckedBytes = kGhstCheckAt - kGhstTypeAt;

/// Channels 1 to 4, which every frame has, and channels of a group, which come by turns.
inline constexpr std::size_t kGhstFineChannels = 4;
inline constexpr std::size_t kGhstGroupChannels = 4;
inline constexpr std::size_t kGhstGroups = 3;
inline constexpr std::size_t kGhstChannels = kGhstFineChannels + kGhstGroups * kGhstGroupChannels;
inline constexpr unsigned kGhstFineBits = 12;
inline constexpr int kGhstFineMost = (1 << kGhstFineBits) - 1;
inline constexpr int kGhstCoarseMost = 0xFF;

/// The upper half of a type says the scale, the lower one what follows channels 1 to 4: a group,
/// the statistics, or what is not known.
inline constexpr std::uint8_t kGhstOldTypes = 0x10;
inline constexpr std::uint8_t kGhstNewTypes = 0x30;
constexpr std::uint8_t ghst_scale_of(std::uint8_t type) {
    return type & 0xF0U;
}
constexpr std::size_t ghst_content_of(unsigned type) {
    return type & 0x0FU;
}
inline constexpr std::uint8_t kGhstStatisticsContent = kGhstGroups;
constexpr bool has_ghst_channels(std::uint8_t type) {
    return ghst_scale_of(type) == kGhstNewTypes || ghst_scale_of(type) == kGhstOldTypes;
}
/// Whether a frame begins as those with channels and a group do: by its first four bytes, the first
/// one lowest.
constexpr bool begins_with_ghst_group(std::uint32_t head) {
    constexpr unsigned kEitherScale = 0xF0U & ~(unsigned{kGhstOldTypes} ^ kGhstNewTypes);
    constexpr unsigned kTypeShift = 8 * kGhstTypeAt;
    constexpr std::uint32_t kBits = 0xFFFFU | kEitherScale << kTypeShift;
    constexpr std::uint32_t kBegin = kGhstAddress | kGhstLength << 8U * kGhstLengthAt |
                                     (kGhstOldTypes & kEitherScale) << kTypeShift;
    return (head & kBits) == kBegin && ghst_content_of(head >> kTypeShift) < kGhstGroups;
}

/// Places of the statistics among the four bytes.
inline constexpr std::size_t kGhstLinkQualityAt = kGhstCoarseAt;
inline constexpr std::size_t kGhstRssiAt = kGhstCoarseAt + 1;
inline constexpr std::size_t kGhstModeAt = kGhstCoarseAt + 2;
inline constexpr std::size_t kGhstPowerAt = kGhstCoarseAt + 3;

/// Scale of the new types: raw zero is 988 us, a step of channels 1 to 4 is 1/4 us, one of the
/// others 4 us.
inline constexpr int kGhstLeastEighths = 988 * 8;
inline constexpr int kGhstFineStepEighths = 2;
inline constexpr int kGhstCoarseStepEighths = 32;

}  // namespace tribus::ghst_wire
