#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "core/pulse.h"

/// Channels as words of whole microseconds, the low byte first. Pure and reentrant.
namespace tribus::microsecond_words {

/// The longest pulse that can be passed on as it is. A longer or a zero word is no pulse.
inline constexpr unsigned kMost = 4095;

inline unsigned microseconds_at(std::span<const std::uint8_t> wire, std::size_t at) {
    return wire[at] | static_cast<unsigned>(wire[at + 1]) << 8U;
}
inline void put_microseconds(std::span<std::uint8_t> wire, std::size_t at, unsigned word) {
    wire[at] = static_cast<std::uint8_t>(word);
    wire[at + 1] = static_cast<std::uint8_t>(word >> 8U);
}

inline std::optional<Pulse> pulse_of(unsigned word) {
    return word >= 1 && word <= kMost ? std::optional(Pulse::from_microseconds(word))
                                      : std::nullopt;
}

/// The pulse to the next whole microsecond, at least 1; the centre for an absent channel.
inline unsigned microseconds_of(const ChannelFrame& frame, std::size_t channel) {
    const Pulse pulse = frame.channel(channel).value_or(kCentrePulse);
    return static_cast<unsigned>(std::max(pulse.whole_microseconds(), 1));
}

}  // namespace tribus::microsecond_words
