#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/codecs/sbus/scale.h"
#include "transports/codecs/wire_words.h"

/// 16 channels of 11 bits in 22 bytes, the lowest bit first: the form in which SBUS and protocols
/// that took it over carry channels (docs/protocols/sbus.md, "Frame"; docs/protocols/crsf.md,
/// "Channels"). Pure and reentrant.
namespace tribus {

inline constexpr std::size_t kPackedChannelBytes = 22;

namespace packed_channels {

// Four channels are a group of 44 bits, all within eight bytes. Even groups begin at a whole byte,
// odd ones end at one. Two channels are a pair of 22 bits. If a group of 64 bits, or a pair of
// 32 bits, is shifted so that the boundary between its two halves is in the middle, one
// multiplication moves all lower, or all upper, channels.
using EightBytes = std::uint64_t;
inline constexpr unsigned kBitsPerChannel = 11;
inline constexpr std::array<std::size_t, 4> kGroupAt{0, 3, 11, 14};
inline constexpr unsigned kOddShift = 64 - 4 * kBitsPerChannel;
inline constexpr unsigned kChannelsApart = 16 - kBitsPerChannel;
inline constexpr unsigned kPairsApart = 32 - 2 * kBitsPerChannel;

inline constexpr std::uint16_t kUp = 1U << kChannelsApart;
inline constexpr Lanes kUppersUp{1, kUp, 1, kUp, 1, kUp, 1, kUp};
inline constexpr Lanes kLowersUp{kUp, 1, kUp, 1, kUp, 1, kUp, 1};

/// Moves bit `from` to bit `to`.
template <unsigned from, unsigned to>
inline PairLanes moved(GroupLanes groups) {
    if constexpr (from <= to) {
        return reinterpret_cast<PairLanes>(groups << (to - from));
    } else {
        return reinterpret_cast<PairLanes>(groups >> (from - to));
    }
}

/// Turns two groups, each from bit `from` on, into pairs: the lower pairs of both, then the upper
/// ones. Bits below a pair do not matter.
template <unsigned from>
inline PairLanes pairs_of(GroupLanes groups) {
    return __builtin_shufflevector(moved<from, kChannelsApart>(groups),
                                   moved<from, kChannelsApart + kPairsApart>(groups), 0, 2, 5, 7);
}

}  // namespace packed_channels

inline SbusLanes unpack_channels(std::span<const std::uint8_t, kPackedChannelBytes> wire) {
    using namespace packed_channels;
    // The order of the pairs in a group, and of the channels in a pair, is that of the machine.
    static_assert(std::endian::native == std::endian::little);
    static_assert(kGroupAt[3] + sizeof(EightBytes) == kPackedChannelBytes);
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

/// Writes 22 bytes, and `next` as the byte after them. Raw values must not exceed 11 bits.
inline void pack_channels(const SbusRaw& raw, std::uint32_t next,
                          std::span<std::uint8_t, kPackedChannelBytes + 1> wire) {
    using namespace packed_channels;
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
    store_word(&wire[0], groups[0] >> kGroupUp | groups[1] << (44U - kGroupUp));
    store_half_word(&wire[8], last_bits(groups[1]));
    store_word(&wire[11], groups[2] >> kGroupUp | groups[3] << (44U - kGroupUp));
    store_half_word(&wire[19], last_bits(groups[3]) | next << 24U);
}

}  // namespace tribus
