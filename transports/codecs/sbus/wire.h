#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/channel_frame.h"
#include "transports/codecs/line_buffer.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/codecs/wire_words.h"

/// Layout of the 25 bytes of an SBUS frame (docs/protocols/sbus.md, "Frame"); only for its decoder
/// and encoder.
namespace tribus::sbus_wire {

inline constexpr std::uint8_t kHeader = 0x0F;
inline constexpr std::size_t kPayloadAt = 1;
inline constexpr std::size_t kFlagsAt = 23;
inline constexpr std::size_t kFooterAt = 24;
inline constexpr unsigned kBitsPerChannel = 11;

inline constexpr std::uint8_t kChannel17Flag = 0x01;
inline constexpr std::uint8_t kChannel18Flag = 0x02;
inline constexpr std::uint8_t kFrameLostFlag = 0x04;
inline constexpr std::uint8_t kFailsafeFlag = 0x08;
inline constexpr std::uint8_t kFlagsUnused = 0xF0;

static_assert(kPayloadAt + kSbusChannels * kBitsPerChannel / 8 == kFlagsAt);
static_assert(kFooterAt + 1 == kSbusFrameLength);

// Four channels are a group of 44 bits, all within eight bytes of the frame. Even groups begin at a
// whole byte, odd ones at half a byte. Two channels are a pair of 22 bits. If a group of 64 bits,
// or a pair of 32 bits, is shifted so that the boundary between its two halves is in the middle,
// one multiplication moves all lower, or all upper, channels.
using EightBytes = std::uint64_t;
inline constexpr std::array<std::size_t, 4> kGroupAt{1, 6, 12, 17};
inline constexpr unsigned kOddShift = 4;
inline constexpr unsigned kChannelsApart = 16 - kBitsPerChannel;
inline constexpr unsigned kPairsApart = 32 - 2 * kBitsPerChannel;
static_assert(kGroupAt[3] + sizeof(EightBytes) == kSbusFrameLength);

inline constexpr std::uint16_t kUp = 1U << kChannelsApart;
inline constexpr Lanes kUppersUp{1, kUp, 1, kUp, 1, kUp, 1, kUp};
inline constexpr Lanes kLowersUp{kUp, 1, kUp, 1, kUp, 1, kUp, 1};

/// Turns two groups, each from bit `From` on, into pairs: the lower pairs of both, then the upper
/// ones.
template <unsigned From>
inline PairLanes pairs_of(GroupLanes groups) {
    const auto lower = reinterpret_cast<PairLanes>(groups << (kChannelsApart - From));
    const auto upper = reinterpret_cast<PairLanes>(groups << (kChannelsApart + kPairsApart - From));
    return __builtin_shufflevector(lower, upper, 0, 2, 5, 7);
}

inline SbusLanes unpack(std::span<const std::uint8_t, kSbusFrameLength> wire) {
    // The order of the pairs in a group, and of the channels in a pair, is that of the machine.
    static_assert(std::endian::native == std::endian::little);
    const auto even =
        pairs_of<0>(GroupLanes{load_word(&wire[kGroupAt[0]]), load_word(&wire[kGroupAt[2]])});
    const auto odd = pairs_of<kOddShift>(
        GroupLanes{load_word(&wire[kGroupAt[1]]), load_word(&wire[kGroupAt[3]])});
    const auto channels = [](PairLanes pairs) {
        const Lanes up = reinterpret_cast<Lanes>(pairs) * kUppersUp;
        return up >> kChannelsApart;
    };
    return {.first = channels(__builtin_shufflevector(even, odd, 0, 2, 4, 6)),
            .last = channels(__builtin_shufflevector(even, odd, 1, 3, 5, 7))};
}

/// Writes the whole frame. Raw values must not exceed 11 bits.
inline void pack(const SbusRaw& raw, std::uint32_t flags, std::uint8_t footer,
                 std::span<std::uint8_t, kSbusFrameLength> wire) {
    constexpr EightBytes kUpperPair = 0xFFFFFFFF'00000000;
    constexpr unsigned kGroupUp = kChannelsApart + kPairsApart;
    std::array<Lanes, kSbusChannels / kLanes> pairs;
    for (std::size_t half = 0; half < pairs.size(); ++half) {
        pairs[half] = reinterpret_cast<Lanes>(load_lanes(&raw[kLanes * half])) * kLowersUp;
    }
    auto groups = to_words(std::bit_cast<SbusRaw>(pairs));
    for (EightBytes& group : groups) {
        group = (group & kUpperPair) | (group << 32U) >> (32U - kPairsApart);
    }
    // Two groups are eleven bytes: eight of them, then 24 bits, after which there is room.
    const auto last_bits = [](EightBytes group) {
        return static_cast<std::uint32_t>(group >> (kGroupUp + 20U));
    };
    wire[0] = kHeader;
    store_word(&wire[1], groups[0] >> kGroupUp | groups[1] << (44U - kGroupUp));
    store_half_word(&wire[9], last_bits(groups[1]));
    store_word(&wire[12], groups[2] >> kGroupUp | groups[3] << (44U - kGroupUp));
    store_half_word(&wire[20], last_bits(groups[3]) | flags << 24U);
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
    static_assert(kGroupAt[3] + 6 == kFlagsAt && kGroupAt[3] + 7 == kFooterAt);
    return (load_word(&wire[kGroupAt[3]]) & kNeitherOf) == 0;
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
