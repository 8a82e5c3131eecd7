#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>

#include "core/channel_frame.h"

/// The channels of a frame as numbers for vector instructions: three groups of eight. The last one
/// begins with channels of the one before, so that all are whole.
namespace tribus {

inline constexpr std::size_t kGroupChannels = 8;
inline constexpr std::array<std::size_t, 3> kGroupBegins{0, kGroupChannels,
                                                         kChannelCount - kGroupChannels};

inline constexpr std::size_t kGroupLanes = kGroupBegins.size() * kGroupChannels;

/// Eighths of a microsecond, or a mask for each channel.
using ChannelGroup = std::array<std::int16_t, kGroupChannels>;

inline ChannelGroup group_of(const ChannelFrame& frame, std::size_t group) {
    static_assert(sizeof(Pulse) == sizeof(std::int16_t));
    ChannelGroup values;
    std::memcpy(values.data(), &frame.pulses()[kGroupBegins[group]], sizeof values);
    return values;
}
/// Channels that are absent must be 0.
inline void set_group(ChannelFrame& frame, std::size_t group, const ChannelGroup& values) {
    std::memcpy(static_cast<void*>(&frame.pulses()[kGroupBegins[group]]), values.data(),
                sizeof values);
}

/// A number for each channel, for instructions with the groups of a frame.
class ChannelNumbers {
  public:
    explicit constexpr ChannelNumbers(std::int16_t all = 0) { numbers_.fill(all); }

    constexpr void set(std::size_t channel, std::int16_t number) {
        for (std::size_t group = 0; group < kGroupBegins.size(); ++group) {
            const std::size_t begin = kGroupBegins[group];
            if (channel >= begin && channel < begin + kGroupChannels) {
                numbers_[group * kGroupChannels + channel - begin] = number;
            }
        }
    }
    /// The numbers of all groups, one after the other.
    const std::int16_t* all() const {
        // So aligned, they are operands of vector instructions in memory.
        return std::assume_aligned<kAlignment>(numbers_.data());
    }
    /// The numbers of a group.
    const std::int16_t* group(std::size_t group) const {
        return std::assume_aligned<kAlignment>(&numbers_[group * kGroupChannels]);
    }

  private:
    static constexpr std::size_t kAlignment = sizeof(ChannelGroup);
    alignas(kAlignment) std::array<std::int16_t, kGroupLanes> numbers_{};
};

/// All bits of the channels that are present, one bit each in `absent` for the others.
constexpr ChannelNumbers present_channels(std::uint32_t absent) {
    ChannelNumbers present;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        present.set(channel, ((absent >> channel) & 1U) == 0 ? -1 : 0);
    }
    return present;
}

/// Whether all channels that `present` masks lie within these limits.
inline bool all_within(const ChannelFrame& frame, std::int16_t least, std::int16_t most,
                       const ChannelNumbers& present) {
    std::array<ChannelGroup, kGroupBegins.size()> groups;
    for (std::size_t group = 0; group < groups.size(); ++group) {
        groups[group] = group_of(frame, group);
    }
    const auto values = std::bit_cast<std::array<std::int16_t, kGroupLanes>>(groups);
    const std::int16_t* const counts = present.all();
    // No branch inside, so that the compiler uses vector instructions.
    std::int16_t outside = 0;
    for (std::size_t lane = 0; lane < values.size(); ++lane) {
        const std::int16_t below = values[lane] < least ? -1 : 0;
        const std::int16_t above = values[lane] > most ? -1 : 0;
        outside = static_cast<std::int16_t>(outside | ((below | above) & counts[lane]));
    }
    return outside == 0;
}

}  // namespace tribus
