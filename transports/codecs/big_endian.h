#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

/// Words of 16 bits with the high byte first. Pure and reentrant.
namespace tribus {

inline std::uint16_t big_endian_at(std::span<const std::uint8_t> bytes, std::size_t at) {
    return static_cast<std::uint16_t>(bytes[at] << 8U | bytes[at + 1]);
}
inline void put_big_endian(std::span<std::uint8_t> bytes, std::size_t at, std::uint16_t word) {
    bytes[at] = static_cast<std::uint8_t>(word >> 8U);
    bytes[at + 1] = static_cast<std::uint8_t>(word);
}

}  // namespace tribus
