#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_ibus2.h"
#include "tests/support/streams.h"
#include "transports/codecs/ibus2/ibus2.h"

/// Frames of i-BUS2 and what a decoder makes of them, for the tests of the decoder.
namespace tribus::test::ibus2_frames {

using namespace reference;
using Types = std::vector<unsigned>;

// Captured from a FTr8B: ArduPilot, AP_IBus2/examples/captures.
inline constexpr std::string_view kCaptured18 =
    "001D07F8770080970F00000000C0000000000000000000000000003028";
inline constexpr std::string_view kCaptured8 = "000F07F96F00DA990F000000000035";
inline constexpr std::string_view kCommand = "05000000000000000000000000000000000000007D";
inline constexpr std::string_view kReply = "06F8100300000000000000000000000000000000A3";
/// 11 bits with a step of 1 us, as in the captures.
inline constexpr unsigned kUsualType = 0x1B;

inline const std::vector<std::optional<double>> kValues18{1492, 1514, 988,  1447, 1500, 1500,
                                                          1500, 988,  1500, 1500, 1500, 1500,
                                                          1500, 1500, 1500, 1500, 1500, 988};
inline const std::vector<std::optional<double>> kValues8{1493, 1513, 1348, 1448,
                                                         1500, 1500, 1500, 1500};

inline std::vector<std::optional<double>> microseconds(const ChannelFrame& frame,
                                                       std::size_t count) {
    std::vector<std::optional<double>> values;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        const auto pulse = frame.channel(channel);
        if (channel < count) {
            values.push_back(pulse ? std::optional(pulse->microseconds()) : std::nullopt);
        } else {
            EXPECT_FALSE(pulse) << channel;
        }
        if (!pulse) {
            EXPECT_EQ(frame.pulses()[channel], Pulse{});
        }
    }
    return values;
}

/// The channels of one frame after a key, alone in a read and byte by byte.
inline ChannelFrame read_with(const Types& types, const Bytes& channels) {
    Ibus2Decoder at_once;
    Ibus2Decoder in_bytes;
    feed(at_once, plain_ibus2_key(types));
    feed(in_bytes, plain_ibus2_key(types), kByteByByte);
    const auto frames = feed(at_once, channels);
    const auto same = feed(in_bytes, channels, kByteByByte);
    EXPECT_EQ(frames.size(), 1U);
    EXPECT_EQ(same.size(), 1U);
    if (frames.empty() || same.empty()) {
        return {};
    }
    EXPECT_TRUE(frames[0].channels.same_content(same[0].channels));
    EXPECT_EQ(frames[0].first_byte, same[0].first_byte);
    EXPECT_EQ(frames[0].length, same[0].length);
    EXPECT_EQ(at_once.skipped_bytes() + in_bytes.skipped_bytes(), 0U);
    return frames[0].channels;
}

/// A line as a receiver drives it, four times: channels, a command, its reply.
inline Bytes four_cycles() {
    Bytes bytes;
    for (int i = 0; i < 4; ++i) {
        append(bytes, plain_ibus2_channels(Types(8, kUsualType),
                                           {-8 - i, 14, -512, 511, 300, 0, 1, 2 + i}));
        append(bytes, from_hex(kCommand));
        append(bytes, from_hex(kReply));
    }
    return bytes;
}

}  // namespace tribus::test::ibus2_frames
