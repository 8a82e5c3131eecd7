#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_fport.h"
#include "tests/support/streams.h"
#include "transports/codecs/fport/fport.h"

/// Frames of F.Port and F.Port 2 and what a decoder makes of them, for the tests of the decoders.
namespace tribus::test::fport_frames {

using namespace reference;
using Raw = std::vector<std::uint16_t>;

// ArduPilot, RCProtocolTest.cpp: fport_bytes, fport2_16ch_bytes, fport2_24ch_bytes.
inline constexpr std::string_view kRecordedFport =
    "7e1900e73bdf5ace071075499c15e0031ff8c0073ef0810f7c0038fa7e";
inline constexpr std::string_view kRecorded16 =
    "18ffac005ff8c0073ef0810f7ce0031ff8c0073ef0810f7c005e98";
inline constexpr std::string_view kRecorded24 =
    "23ffe003df2cc2c70af0b18215e09b382bc0073ef0810f7ce0031ff8c0073ef0810f7c005b02";
// Computed: 08, physical id 1B, primitive 10 (data), application id 0210, 4 bytes.
inline constexpr std::string_view kTelemetry2 = "081b10100212345678ad";
// Computed: a request and a reply of F.Port, the reply without markers and with an escaped 7E.
inline constexpr std::string_view kRequest = "7e080100000000000000f67e";
inline constexpr std::string_view kReply = "0881107d5e1000000000d7";

/// What a test needs of one of the two formats.
struct Format {
    std::string_view name;
    std::unique_ptr<ByteDecoder> (*decoder)();
    Bytes (*channels)(const Raw& raw, std::uint8_t flags, std::uint8_t rssi);
    std::vector<PlainFportFrame> (*plain)(const Bytes& stream);
    Bytes (*telemetry)();
};

inline const Format kVersion1{
    .name = "Fport",
    .decoder = [] { return std::unique_ptr<ByteDecoder>(std::make_unique<FportDecoder>()); },
    .channels = plain_fport1,
    .plain = [](const Bytes& bytes) { return plain_fport_frames(bytes, plain_fport1_frame); },
    .telemetry =
        [] {
            Bytes both = from_hex(kRequest);
            append(both, from_hex(kReply));
            return both;
        },
};
inline const Format kVersion2{
    .name = "Fport2",
    .decoder = [] { return std::unique_ptr<ByteDecoder>(std::make_unique<Fport2Decoder>()); },
    .channels = plain_fport2,
    .plain = [](const Bytes& bytes) { return plain_fport_frames(bytes, plain_fport2_frame); },
    .telemetry =
        [] {
            Bytes both = from_hex(kTelemetry2);
            append(both, from_hex(kTelemetry2));
            return both;
        },
};

/// Raw values that differ from each other, none with an escape.
inline Raw some(std::uint16_t first, std::size_t count = 16) {
    Raw raw(count);
    for (std::size_t i = 0; i < count; ++i) {
        raw[i] = static_cast<std::uint16_t>((first + 131 * i) % 2048);
    }
    return raw;
}

inline void expect_raw(const ChannelFrame& frame, const Raw& raw) {
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (channel >= raw.size()) {
            ASSERT_FALSE(frame.has(channel)) << channel;
            ASSERT_EQ(frame.pulses()[channel], Pulse{});
            continue;
        }
        ASSERT_EQ(frame.channel(channel)->eighths(), (raw[channel] - 992) * 5 + 12000) << channel;
    }
}

}  // namespace tribus::test::fport_frames
