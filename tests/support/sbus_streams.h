#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/support/streams.h"
#include "transports/codecs/sbus/sbus.h"

/// SBUS streams whose payloads hide where a frame starts.
namespace tribus::test {

using SbusPayload = std::array<std::uint8_t, 22>;

inline Bytes sbus_frame(const SbusPayload& payload, std::uint8_t flags, std::uint8_t footer) {
    Bytes frame(kSbusFrameLength);
    frame[0] = 0x0F;
    std::ranges::copy(payload, frame.begin() + 1);
    frame[23] = flags;
    frame[24] = footer;
    return frame;
}

/// Returns a payload that repeats the pattern.
inline SbusPayload payload_of(std::string_view hex) {
    const Bytes pattern = from_hex(hex);
    SbusPayload payload{};
    for (std::size_t at = 0; at < payload.size(); ++at) {
        payload[at] = pattern[at % pattern.size()];
    }
    return payload;
}

struct SbusSticks {
    std::string name;
    /// Returns the payload of the n-th frame.
    std::function<SbusPayload(std::uint32_t)> payload;
};

inline SbusSticks still(std::string name, const SbusPayload& payload) {
    return {std::move(name), [payload](std::uint32_t) { return payload; }};
}

/// Sticks that stand still, with payload bytes that look like headers, flags and footers. This is
/// the hard case, because a false frame boundary looks the same in every frame.
inline std::vector<SbusSticks> hard_sticks_that_stand_still() {
    std::vector<SbusSticks> all;
    for (const std::string_view pattern :
         {"0f", "0f 00", "00 0f", "00 00 0f", "00 0f 00", "0f 00 00", "0f 0f 00", "0f 00 0f",
          "0f 04 0f 08", "00", "ff", "03", "03 0f", "0b 00 0f"}) {
        all.push_back(still("payload of " + std::string(pattern), payload_of(pattern)));
    }
    // All 992; docs/protocols/sbus.md, "Vectors".
    all.push_back(still("all 992", payload_of("e0 03 1f f8 c0 07 3e f0 81 0f 7c")));
    // 8 channels, the unused ones 0; ArduPilot's RCProtocolTest.
    all.push_back(
        still("unused channels 0",
              payload_of("4c 1c 5f 32 34 38 dd 89 83 0f 7c 00 00 00 00 00 00 00 00 00 00 00")));
    return all;
}

/// Returns a payload of bytes that have a meaning for a decoder (`hard`), or of any bytes.
inline SbusPayload random_payload(Random& random, bool hard) {
    constexpr std::array<std::uint8_t, 9> kHard{0x0F, 0x00, 0x04, 0x0F, 0x10,
                                                0x08, 0x03, 0x0F, 0x00};
    SbusPayload payload{};
    for (std::uint8_t& byte : payload) {
        byte = hard ? kHard[random.below(kHard.size())] : random.byte();
    }
    return payload;
}

inline std::vector<SbusSticks> random_sticks(std::uint32_t count) {
    std::vector<SbusSticks> all;
    for (std::uint32_t seed = 1; seed <= count; ++seed) {
        for (const bool hard : {false, true}) {
            const std::string name =
                (hard ? "hard bytes, seed " : "any bytes, seed ") + std::to_string(seed);
            Random random(seed);
            all.push_back(still(name + ", still", random_payload(random, hard)));
            all.push_back({name + ", moving", [seed, hard](std::uint32_t frame) {
                               Random each(1000 * seed + frame + 1);
                               return random_payload(each, hard);
                           }});
        }
    }
    return all;
}

inline std::vector<SbusSticks> all_sticks(std::uint32_t random_count) {
    auto all = hard_sticks_that_stand_still();
    std::ranges::move(random_sticks(random_count), std::back_inserter(all));
    return all;
}

/// Each of the 32 slot ids, then two bytes; docs/protocols/sbus.md, "Footer and SBUS2".
inline Bytes slot_triple(std::uint32_t slot, std::uint8_t first, std::uint8_t second) {
    return {static_cast<std::uint8_t>(slot << 3U | 0x03U), first, second};
}

inline FrameStream sbus_stream(const SbusSticks& sticks, std::uint8_t flags,
                               std::uint32_t frame_count) {
    FrameStream stream;
    for (std::uint32_t frame = 0; frame < frame_count; ++frame) {
        stream.add_frame(sbus_frame(sticks.payload(frame), flags, 0x00));
    }
    return stream;
}

/// An SBUS2 stream as a Futaba receiver sends it: footers 24, 34, 04, 14 in turn, slot 0 after 04.
/// With more triples, sensors fill the slots after every frame.
inline FrameStream sbus2_stream(const SbusSticks& sticks, std::uint8_t flags,
                                std::uint32_t frame_count, std::uint32_t triples) {
    FrameStream stream;
    for (std::uint32_t frame = 0; frame < frame_count; ++frame) {
        const auto footer = static_cast<std::uint8_t>((frame + 2) % 4 << 4U | 0x04U);
        stream.add_frame(sbus_frame(sticks.payload(frame), flags, footer));
        for (std::uint32_t slot = 0; slot < triples && (triples > 1 || footer == 0x04); ++slot) {
            // 4.6 V; docs/protocols/sbus.md, "Footer and SBUS2".
            stream.add_other(slot_triple(slot, 0xC0, 0x2E));
        }
    }
    return stream;
}

}  // namespace tribus::test
