#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/channel_frame.h"

/// The channels of a frame as numbers for vector instructions.
namespace tribus {

/// A multiple of eight. Those behind the last channel are 0.
inline constexpr std::size_t kChannelLanes = (kChannelCount + 7) / 8 * 8;
/// Eighths of a microsecond, or a mask for each channel.
using ChannelLanes = std::array<std::int16_t, kChannelLanes>;

inline ChannelLanes lanes_of(const ChannelFrame& frame) {
    static_assert(sizeof(Pulse) == sizeof(std::int16_t));
    ChannelLanes lanes{};
    std::memcpy(lanes.data(), frame.pulses().data(), sizeof frame.pulses());
    return lanes;
}

/// All bits of the channels that are present, one bit each in `absent` for the others.
constexpr ChannelLanes present_lanes(std::uint32_t absent) {
    ChannelLanes present{};
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        present[channel] = static_cast<std::int16_t>(((absent >> channel) & 1U) == 0 ? -1 : 0);
    }
    return present;
}

/// Whether all numbers that `present` masks lie within these limits.
inline bool all_within(const ChannelLanes& lanes, std::int16_t least, std::int16_t most,
                       const ChannelLanes& present) {
    // No branch inside, so that the compiler uses vector instructions.
    std::int16_t outside = 0;
    for (std::size_t lane = 0; lane < kChannelLanes; ++lane) {
        const std::int16_t below = lanes[lane] < least ? -1 : 0;
        const std::int16_t above = lanes[lane] > most ? -1 : 0;
        outside = static_cast<std::int16_t>(outside | ((below | above) & present[lane]));
    }
    return outside == 0;
}

}  // namespace tribus
