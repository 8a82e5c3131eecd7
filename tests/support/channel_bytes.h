#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/channel_frame.h"
#include "core/time.h"
#include "tests/support/streams.h"
#include "transports/codecs/codec.h"

/// Channels as numbers, and what an encoder makes of them.
namespace tribus::test {

/// The pulses of the channels up to the first absent one.
inline std::vector<double> pulses_of(const ChannelFrame& frame) {
    std::vector<double> values;
    for (std::size_t channel = 0; channel < kChannelCount && frame.has(channel); ++channel) {
        values.push_back(frame.channel(channel)->microseconds());
    }
    return values;
}

/// The numbers, from 1 on, of the channels that the frame has.
inline std::vector<std::size_t> present(const ChannelFrame& frame) {
    std::vector<std::size_t> channels;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (frame.has(channel)) {
            channels.push_back(channel + 1);
        }
    }
    return channels;
}

/// A good frame with these pulses.
inline ChannelFrame frame_of_microseconds(const std::vector<double>& values) {
    ChannelFrame frame;
    frame.failsafe = false;
    frame.frame_lost = false;
    for (std::size_t channel = 0; channel < values.size(); ++channel) {
        frame.set(channel, Pulse::from_fractional_microseconds(values[channel]));
    }
    return frame;
}

inline Bytes encoded(ByteEncoder& encoder, const ChannelFrame& frame, Instant now = {}) {
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder.write(frame, wire, now);
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

}  // namespace tribus::test
