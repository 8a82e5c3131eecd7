#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "tests/support/streams.h"
#include "transports/codecs/sbus/sbus.h"

/// SBUS frames from public sources, with their origin.
namespace tribus::test {

/// docs/protocols/sbus.md, "Vectors".
inline constexpr std::string_view kAll992 =
    "0f e0 03 1f f8 c0 07 3e f0 81 0f 7c e0 03 1f f8 c0 07 3e f0 81 0f 7c 00 00";
inline constexpr std::string_view kAll1024 =
    "0f 00 04 20 00 01 08 40 00 02 10 80 00 04 20 00 01 08 40 00 02 10 80 00 00";
inline constexpr std::string_view kHundreds =
    "0f 64 40 06 4b 20 43 1f 2c f1 0a 64 84 43 1f 13 61 49 51 bc 72 17 c8 00 00";
/// Futaba R7008SB in FASSTest 14CH and 12CH; LANE in docs/protocols/sbus.md, "Sources".
inline constexpr std::string_view kFasstest14 =
    "0f 04 1c a1 43 09 48 40 04 7a 10 2c 00 04 20 58 c0 13 07 38 00 10 80 00 04";
inline constexpr std::string_view kFasstest12 =
    "0f 00 1c 20 5b 09 08 c0 13 7a 10 2c 00 04 20 00 01 08 40 00 02 10 80 00 08";
/// TFR8SB; the same document.
inline constexpr std::string_view kTfr8sb =
    "0f 04 1c a1 43 0b 48 40 04 7a 10 2c 00 04 20 58 c0 13 07 38 00 10 80 00 00";
/// A FrSky receiver; github.com/Cleric-K/vJoySerialFeeder issue 3.
inline constexpr std::string_view kFrsky =
    "0f e5 03 1f f8 c0 07 3e f0 81 0f 7c e0 03 06 f8 80 91 3d f0 81 0f 7c 00 00";
/// 8 channels, the unused ones 0; ArduPilot's RCProtocolTest, which expects the values below.
inline constexpr std::string_view kUnusedZero =
    "0f 4c 1c 5f 32 34 38 dd 89 83 0f 7c 00 00 00 00 00 00 00 00 00 00 00 00 00";
/// FrSky's frame of 24 channels, all in the centre (captures/field/f08_sbus24_centre.txt).
inline constexpr std::string_view kCentred24 =
    "0f e0 03 1f f8 c0 07 3e f0 81 0f 7c e0 03 1f f8 c0 07 3e f0 81 0f 7c e0 03 1f f8 c0 07 3e f0 "
    "81 0f 7c 00 00";

using RawValues = std::vector<int>;

inline RawValues raw_values(const SbusFrame& frame) {
    return {frame.raw.begin(), frame.raw.end()};
}

inline SbusFrame parse(std::string_view hex) {
    const Bytes bytes = from_hex(hex);
    return parse_sbus(std::span(bytes).first<kSbusFrameLength>());
}

}  // namespace tribus::test
