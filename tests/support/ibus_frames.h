#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "core/channel_frame.h"
#include "tests/support/ibus_checksum.h"
#include "tests/support/streams.h"
#include "transports/codecs/ibus/ibus.h"

/// i.Bus frames that are quoted in public, with their origin.
namespace tribus::test {

/// FS-i6 and FS-iA6B, quoted in IBusBM; docs/protocols/ibus.md, "Vectors".
inline constexpr std::string_view kIa6bFrame =
    "20 40 db 05 dc 05 54 05 dc 05 e8 03 d0 07 d2 05 e8 03 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 "
    "da f3";
/// FS-i6 and FS-iA6B; basejunction.wordpress.com 2015-08-23.
inline constexpr std::string_view kIa6bFrame2015 =
    "20 40 dc 05 db 05 ef 03 dd 05 d0 07 d0 07 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 "
    "54 f3";
/// ArduPilot's RCProtocolTest.
inline constexpr std::string_view kArduPilotFrame =
    "20 40 dc 05 dc 05 e8 03 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 "
    "47 f3";
/// FTr8B receiver (AFHDS 3), 18 channels; first frame of ArduPilot's capture ibus-FTr8B.csv.
/// Channels 15 to 18 are 1500 us (0x5DC); its digit 5 makes bytes 0x55, the other variant's header.
inline constexpr std::string_view kFtr8bFrame =
    "20 40 d5 c5 eb d5 45 55 a8 c5 dc d5 dc 55 dc c5 dc d5 dc 55 dc c5 dc d5 dc 55 dc 05 dc 05 "
    "94 ec";
/// Betaflight's unit test, synthetic: channel n is n - 1, command byte 0; docs/protocols/ibus.md,
/// "Vectors".
inline constexpr std::string_view kBetaflight18 =
    "20 00 00 e0 01 00 02 00 03 f0 04 00 05 00 06 00 07 10 08 00 09 10 0a 10 0b 00 0c 00 0d 00 "
    "84 fd";
/// Betaflight's unit test, synthetic: channels 0 to 13; docs/protocols/ibus.md, "Variants".
inline constexpr std::string_view kBetaflightIa6 =
    "55 00 00 01 00 02 00 03 00 04 00 05 00 06 00 07 00 08 00 09 00 0a 00 0b 00 0c 00 0d 00 5b 00";
/// FTr8B in i-BUS2 mode; ArduPilot's captures ibus2-FTr8B-fast8ch.csv,
/// ibus2-including-subtype-1.csv.
inline constexpr std::string_view kIbus2Channels = "00 0f 07 f9 77 00 80 99 0f 00 00 00 00 00 e7";
inline constexpr std::string_view kIbus2MoreChannels =
    "00 0f 07 f9 6f 00 da 99 0f 00 00 00 00 00 35";
inline constexpr std::string_view kIbus2Command =
    "05 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 7d";
inline constexpr std::string_view kIbus2Response =
    "06 f8 10 03 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 a3";

/// Returns the whole microseconds of each channel, or -1 for a channel that is not present.
inline std::vector<int> whole_microseconds(const ChannelFrame& frame) {
    std::vector<int> values;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        const auto pulse = frame.channel(channel);
        values.push_back(pulse ? pulse->whole_microseconds() : -1);
    }
    return values;
}

/// Returns the frame if `wire` is exactly one frame.
inline std::optional<ChannelFrame> decode_one(const Bytes& wire,
                                              IbusSlots slots = IbusSlots::nibbles) {
    IbusDecoder decoder(slots);
    const auto frames = feed(decoder, wire);
    return frames.size() == 1 ? std::optional(frames[0].channels) : std::nullopt;
}

/// Returns a servo frame with a payload of any allowed length and its checksum.
inline Bytes servo_frame(const Bytes& payload, std::uint8_t command) {
    Bytes frame{static_cast<std::uint8_t>(payload.size() + 4), command};
    append(frame, payload);
    return with_ibus_checksum(frame);
}

}  // namespace tribus::test
