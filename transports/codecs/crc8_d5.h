#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/codecs/crc8.h"

/// CRC-8 of CRSF and GHST: polynomial D5, start 0, most significant bit first
/// (docs/protocols/crsf.md, "Frame"). Pure and reentrant.
namespace tribus {

/// The CRC of a number of bytes that is known, without loops.
template <std::size_t bytes_count>
std::uint8_t crc8_d5(std::span<const std::uint8_t, bytes_count> bytes) {
    return crc8<0xD5>(0, bytes);
}

inline std::uint8_t crc8_d5(std::span<const std::uint8_t> bytes) {
    return crc8<0xD5>(0, bytes);
}

}  // namespace tribus
