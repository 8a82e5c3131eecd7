#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/codecs/sbus.h"
#include "transports/codecs/wire_words.h"

/// Where things stand in the 25 bytes of an SBUS frame; for its decoder and encoder only.
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

// Four channels at a time: 44 bits, which all stand within eight bytes of the frame, even groups
// from a whole byte on and odd ones from half a byte on. Between those bits and four numbers of 16
// there are two steps: apart into two halves of 22, and each half into two channels of 11.
using EightBytes = std::uint64_t;
inline constexpr std::array<std::size_t, 4> kGroupAt{1, 6, 12, 17};
inline constexpr unsigned kOddShift = 4;
inline constexpr EightBytes kLowHalf = 0x00000000'003FFFFF;
inline constexpr EightBytes kHighHalf = 0x003FFFFF'00000000;
inline constexpr unsigned kHalvesApart = 32 - 22;
inline constexpr EightBytes kLowChannels = 0x000007FF'000007FF;
inline constexpr EightBytes kHighChannels = 0x07FF0000'07FF0000;
inline constexpr unsigned kChannelsApart = 16 - 11;
static_assert(kGroupAt[3] + sizeof(EightBytes) == kSbusFrameLength);

/// 44 bits to four times 16.
inline EightBytes spread(EightBytes bits) {
    const EightBytes halves = (bits & kLowHalf) | ((bits << kHalvesApart) & kHighHalf);
    return (halves & kLowChannels) | ((halves << kChannelsApart) & kHighChannels);
}

/// And back.
inline EightBytes gather(EightBytes channels) {
    const EightBytes halves =
        (channels & kLowChannels) | ((channels & kHighChannels) >> kChannelsApart);
    return (halves & kLowHalf) | ((halves & kHighHalf) >> kHalvesApart);
}

inline SbusRaw unpack(std::span<const std::uint8_t, kSbusFrameLength> wire) {
    std::array<EightBytes, 2> even{load_word(&wire[kGroupAt[0]]), load_word(&wire[kGroupAt[2]])};
    std::array<EightBytes, 2> odd{load_word(&wire[kGroupAt[1]]), load_word(&wire[kGroupAt[3]])};
    for (std::size_t i = 0; i < 2; ++i) {
        even[i] = spread(even[i]);
        odd[i] = spread(odd[i] >> kOddShift);
    }
    return from_words(std::array{even[0], odd[0], even[1], odd[1]});
}

/// Writes all but the header.
inline void pack(const SbusRaw& raw, EightBytes flags, EightBytes footer,
                 std::span<std::uint8_t, kSbusFrameLength> wire) {
    auto groups = to_words(raw);
    for (EightBytes& group : groups) {
        group = gather(group);
    }
    store_word(&wire[1], groups[0] | groups[1] << 44U);
    store_word(&wire[9], groups[1] >> 20U | groups[2] << 24U);
    store_word(&wire[17], groups[2] >> 40U | groups[3] << 4U | flags << 48U | footer << 56U);
}

}  // namespace tribus::sbus_wire
