#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/codecs/crc.h"
#include "transports/codecs/wire_words.h"

/// CRC-8 of CRSF and GHST: polynomial D5, start 0, most significant bit first
/// (docs/protocols/crsf.md, "Frame").
namespace tribus {

using Crc8D5 = Crc<std::uint8_t, 0xD5>;

inline constexpr std::size_t kCrc8D5FoldedBytes = 24;

/// The remainder of 24 bytes by the polynomial: 0 if the last byte is the CRC of those before; that
/// CRC if the last byte is 0. Folds the bytes into eight before it looks into tables, as x^96 has
/// the remainder x^3, and x^64 the remainder x^6 + x + 1. Pure and reentrant.
inline std::uint8_t crc8_d5_remainder(std::span<const std::uint8_t, kCrc8D5FoldedBytes> bytes) {
    const std::uint8_t* const first = bytes.data();
    // Adds bytes 0 to 11, times x^3, to bytes 12 to 23: the lower 64 bits, and those above.
    const std::uint64_t lower =
        load_word_highest_first(first + 4) << 3U ^ load_word_highest_first(first + 16);
    const std::uint64_t upper =
        load_word_highest_first(first) >> (32U - 3U) ^ load_half_word_highest_first(first + 12);
    return Crc8D5::remainder(lower ^ upper ^ upper << 1U ^ upper << 6U);
}

}  // namespace tribus
