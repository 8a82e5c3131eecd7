#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/channel_frame.h"
#include "transports/codecs/line_buffer.h"
#include "transports/codecs/sbus/packed_channels.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/codecs/wire_words.h"

/// Layout of the 25 bytes of an SBUS frame (docs/protocols/sbus.md, "Frame"); only for its decoder
/// and encoder.
namespace tribus::sbus_wire {

inline constexpr std::uint8_t kHeader = 0x0F;
inline constexpr std::size_t kPayloadAt = 1;
inline constexpr std::size_t kFlagsAt = 23;
inline constexpr std::size_t kFooterAt = 24;

inline constexpr std::uint8_t kChannel17Flag = 0x01;
inline constexpr std::uint8_t kChannel18Flag = 0x02;
inline constexpr std::uint8_t kFrameLostFlag = 0x04;
inline constexpr std::uint8_t kFailsafeFlag = 0x08;
inline constexpr std::uint8_t kFlagsUnused = 0xF0;

static_assert(kPayloadAt + kPackedChannelBytes == kFlagsAt);
static_assert(kFooterAt + 1 == kSbusFrameLength);

inline SbusLanes unpack(std::span<const std::uint8_t, kSbusFrameLength> wire) {
    return unpack_channels(wire.subspan<kPayloadAt, kPackedChannelBytes>());
}

/// Writes the whole frame. Raw values must not exceed 11 bits.
inline void pack(const SbusRaw& raw, std::uint32_t flags, std::uint8_t footer,
                 std::span<std::uint8_t, kSbusFrameLength> wire) {
    wire[0] = kHeader;
    pack_channels(raw, flags, wire.subspan<kPayloadAt, kPackedChannelBytes + 1>());
    wire[kFooterAt] = footer;
}

inline bool flags_allowed(std::uint8_t flags) {
    return (flags & kFlagsUnused) == 0;
}

/// 00 is SBUS; x4 is SBUS2 and 08 FASSTest 12CH, both with slots after the frame
/// (docs/protocols/sbus.md, "Footer and SBUS2").
inline bool footer_allowed(std::uint8_t footer) {
    const unsigned low = footer & 0x0FU;
    return low == 0x0 || low == 0x4 || low == 0x8;
}
inline bool slots_follow(std::uint8_t footer) {
    return (footer & 0x0FU) != 0;
}

/// Whether a byte is one of the 32 slot ids: a five-bit number, then 011 (docs/protocols/sbus.md,
/// "Footer and SBUS2").
inline bool is_slot_id(std::uint8_t byte) {
    return (byte & 0x07U) == 0x03;
}

inline bool well_formed_wire(std::span<const std::uint8_t, kSbusFrameLength> wire) {
    return wire[0] == kHeader && flags_allowed(wire[kFlagsAt]) && footer_allowed(wire[kFooterAt]);
}

/// Whether the flags are allowed and the footer announces no slots.
inline bool flags_and_footer_plain(std::span<const std::uint8_t, kSbusFrameLength> wire) {
    constexpr std::uint64_t kNeitherOf = std::uint64_t{kFlagsUnused} << 48U | 0x0FULL << 56U;
    constexpr std::size_t kLastWord = kSbusFrameLength - sizeof(std::uint64_t);
    static_assert(kLastWord + 6 == kFlagsAt && kLastWord + 7 == kFooterAt);
    return (load_word(&wire[kLastWord]) & kNeitherOf) == 0;
}

inline bool flags_and_footer_allowed(const std::uint8_t* frame) {
    return flags_allowed(frame[kFlagsAt]) && footer_allowed(frame[kFooterAt]);
}

/// Number of bytes before `end` that come before the first possible frame: bytes that are no
/// header, and headers without flags and footer in their places.
inline std::size_t noise_in(std::span<const std::uint8_t> bytes, std::size_t end) {
    std::size_t at = 0;
    for (; at < end; ++at) {
        if (bytes[at] == kHeader &&
            (bytes.size() - at < kSbusFrameLength || flags_and_footer_allowed(&bytes[at]))) {
            break;
        }
    }
    return at;
}

/// The same if some of the first bytes are damaged.
inline std::size_t noise_in(std::span<const std::uint8_t> bytes, std::size_t end,
                            const DamageMarks& marks) {
    constexpr std::uint64_t kWhole = (1ULL << kSbusFrameLength) - 1;
    std::size_t at = 0;
    for (; at < end; ++at) {
        // A damaged byte is kept as 0, which is no header.
        if (bytes[at] == kHeader &&
            (bytes.size() - at < kSbusFrameLength ||
             ((marks.from(at) & kWhole) == 0 && flags_and_footer_allowed(&bytes[at])))) {
            break;
        }
    }
    return at;
}

/// The part of a ChannelFrame that depends only on the flags, for each of their 16 values.
inline constexpr auto kByFlags = [] {
    std::array<ChannelFrame, 16> frames{};
    for (unsigned flags = 0; flags < frames.size(); ++flags) {
        ChannelFrame& frame = frames[flags];
        frame.frame_lost = (flags & kFrameLostFlag) != 0;
        frame.failsafe = (flags & kFailsafeFlag) != 0;
        frame.origin = Origin::sbus;
        for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
            frame.set(channel, Pulse{});
        }
        frame.set(16, (flags & kChannel17Flag) != 0 ? kSwitchOnPulse : kSwitchOffPulse);
        frame.set(17, (flags & kChannel18Flag) != 0 ? kSwitchOnPulse : kSwitchOffPulse);
    }
    return frames;
}();

}  // namespace tribus::sbus_wire
