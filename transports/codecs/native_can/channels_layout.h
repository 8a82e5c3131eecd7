#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/channel_frame.h"

/// Position of each value in the native CAN format (docs/protocols/can.md, "Native format";
/// deploy/can/native.dbc): the one table for the codec and for the DBC text that describes it.
///
/// Classic frames, 8 bytes. Four of them have four channels each, in order:
///   byte 0      CRC-8
///   byte 1      counter in the low nibble; then failsafe, frame lost, digital 17, digital 18
///   bytes 2-7   four 12-bit values, low bits first
/// and the fifth:
///   bytes 0, 1  the same
///   bytes 2-4   channels 17 and 18, 12 bits each
///   byte 5      link quality in the low 7 bits; lowest bit of the channel count
///   byte 6      the other bits of the channel count; source in the high nibble
///   byte 7      age
/// FD frame, 48 bytes, words low byte first:
///   bytes 0, 1  CRC-16
///   byte 2      counter
///   byte 3      failsafe, frame lost, digital 17, digital 18; source in the high nibble
///   byte 4      channel count in the low 5 bits
///   byte 5      link quality in the low 7 bits
///   bytes 6, 7  age
///   bytes 8-43  18 words, one for each channel
///   bytes 44-47 zero: an FD frame has no length between 32 and 48
namespace tribus::can_channels {

/// Bits of a payload, lowest bit first. Bit 8 is the lowest of byte 1 (Intel order in a DBC).
struct Field {
    unsigned start = 0;
    unsigned width = 0;  ///< at most 16

    constexpr unsigned most() const { return (1U << width) - 1; }
    constexpr unsigned end() const { return start + width; }
};

/// Reads a field.
constexpr std::uint16_t get(std::span<const std::uint8_t> payload, Field field) {
    std::uint32_t bits = 0;
    const std::size_t last = (field.end() - 1) / 8;
    for (std::size_t at = last + 1; at-- > field.start / 8;) {
        bits = bits << 8U | payload[at];
    }
    return static_cast<std::uint16_t>((bits >> field.start % 8) & field.most());
}

/// The field must be zero before. Bits of `value` above its width are cut off.
constexpr void put(std::span<std::uint8_t> payload, Field field, unsigned value) {
    std::uint32_t bits = (value & field.most()) << field.start % 8;
    for (std::size_t at = field.start / 8; bits != 0; ++at, bits >>= 8U) {
        payload[at] = static_cast<std::uint8_t>(payload[at] | bits);
    }
}

inline constexpr std::size_t kQuads = 4;
inline constexpr std::size_t kChannelsPerQuad = 4;
inline constexpr std::size_t kQuadChannels = kQuads * kChannelsPerQuad;
inline constexpr std::size_t kTailChannels = kChannelCount - kQuadChannels;
/// Distance of each frame's id from the base id: four quads, the tail, the FD frame.
inline constexpr std::size_t kTailIndex = kQuads;
inline constexpr std::size_t kFdIndex = kQuads + 1;
inline constexpr std::size_t kIds = kFdIndex + 1;

inline constexpr std::size_t kClassicLength = 8;
inline constexpr std::size_t kFdLength = 48;

/// E2E data id of the frame with the base id. Those of the others follow it.
inline constexpr std::uint16_t kFirstDataId = 0x5243;

inline constexpr std::uint32_t kDefaultBaseId = 0x300;
inline constexpr unsigned kDefaultPeriodMilliseconds = 10;

/// Scale of pulses on the wire: raw = (eighths of a microsecond - offset) / step.
struct PulseScale {
    std::int32_t offset_eighths = 0;
    std::int32_t step_eighths = 1;
    std::uint16_t not_available = 0;  ///< every smaller raw value is a pulse
};
/// Steps of 0.5 us from 476 us: keeps all 2048 values of SBUS and all microseconds of i.Bus apart.
inline constexpr PulseScale kClassicPulse{476 * 8, 4, 0xFFF};
/// Steps of 0.125 us from 0: exactly those of a Pulse.
inline constexpr PulseScale kFdPulse{0, 1, 0xFFFF};

/// Raw link quality is 0 to 100 %, or "not available".
inline constexpr std::uint8_t kMostLinkQuality = 100;
inline constexpr std::uint8_t kLinkQualityNotAvailable = 127;

/// The format that the values were first read from.
struct Source {
    std::uint8_t raw = 0;
    Origin origin = Origin::none;
    std::string_view name;  ///< in the DBC
};
inline constexpr std::array<Source, 6> kSources{{{0, Origin::none, "None"},
                                                 {1, Origin::ibus, "IBus"},
                                                 {2, Origin::sbus, "SBus"},
                                                 {3, Origin::dronecan, "DroneCAN"},
                                                 {4, Origin::can, "CanNative"},
                                                 {5, Origin::dbc, "DbcMapped"}}};
inline constexpr std::uint8_t kSourceNotAvailable = 15;

/// Scale of the age of the values when they were sent. An age above the highest is sent as the
/// highest.
struct AgeScale {
    unsigned step_microseconds = 1;
    std::uint16_t not_available = 0;  ///< every smaller raw value is an age
};
inline constexpr AgeScale kTailAgeScale{250, 0xFF};
inline constexpr AgeScale kFdAgeScale{10, 0xFFFF};

/// Number of status bits of each frame. The arrays of flags have them in wire order.
inline constexpr std::size_t kFlagCount = 4;

inline constexpr Field kCrc8{0, 8};
inline constexpr Field kCounter{8, 4};
inline constexpr std::array<Field, kFlagCount> kFlags{{{12, 1}, {13, 1}, {14, 1}, {15, 1}}};
constexpr Field classic_channel(std::size_t place) {
    return {16 + 12 * static_cast<unsigned>(place), 12};
}
inline constexpr Field kTailLinkQuality{40, 7};
inline constexpr Field kTailChannelCount{47, 5};
inline constexpr Field kTailSource{52, 4};
inline constexpr Field kTailAge{56, 8};

inline constexpr Field kFdCrc{0, 16};
inline constexpr Field kFdCounter{16, 8};
inline constexpr std::array<Field, kFlagCount> kFdFlags{{{24, 1}, {25, 1}, {26, 1}, {27, 1}}};
inline constexpr Field kFdSource{28, 4};
inline constexpr Field kFdChannelCount{32, 5};
inline constexpr Field kFdLinkQuality{40, 7};
inline constexpr Field kFdAge{48, 16};
constexpr Field fd_channel(std::size_t channel) {
    return {64 + 16 * static_cast<unsigned>(channel), 16};
}

static_assert(classic_channel(kChannelsPerQuad - 1).end() == 8 * kClassicLength);
static_assert(classic_channel(kTailChannels - 1).end() == kTailLinkQuality.start);
static_assert(kTailAge.end() == 8 * kClassicLength);
static_assert(fd_channel(kChannelCount - 1).end() <= 8 * kFdLength);

}  // namespace tribus::can_channels
