#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

/// CRC-16 with polynomial 1021, least significant bit first (8408 in that order), no final XOR: the
/// one of Jeti EX Bus with start 0 (docs/protocols/exbus.md, "Frame"). Pure and reentrant.
namespace tribus {

namespace crc16_8408_tables {

inline constexpr std::size_t kSlice = 8;
using CrcTable = std::array<std::uint16_t, 256>;

constexpr std::uint16_t shifted_by_a_byte(std::uint16_t crc) {
    constexpr unsigned kPolynomial = 0x8408;
    unsigned shifted = crc;
    for (int bit = 0; bit < 8; ++bit) {
        shifted = (shifted & 1U) != 0 ? (shifted >> 1U) ^ kPolynomial : shifted >> 1U;
    }
    return static_cast<std::uint16_t>(shifted);
}

/// Table `n` has the effect of a byte that `n` further bytes follow, so that a slice of bytes needs
/// no result of the byte before.
inline constexpr std::array<CrcTable, kSlice> kTables = [] {
    std::array<CrcTable, kSlice> tables{};
    for (std::size_t byte = 0; byte < tables[0].size(); ++byte) {
        auto crc = static_cast<std::uint16_t>(byte);
        for (CrcTable& table : tables) {
            crc = shifted_by_a_byte(crc);
            table[byte] = crc;
        }
    }
    return tables;
}();

/// The first two bytes of the slice meet the CRC so far.
template <std::size_t... at>
std::uint16_t of_slice(std::uint16_t crc, const std::uint8_t* bytes, std::index_sequence<at...>) {
    constexpr std::size_t kLast = sizeof...(at) - 1;
    return static_cast<std::uint16_t>(
        (kTables[kLast - at][at < 2 ? bytes[at] ^ (crc >> (8 * at) & 0xFFU) : bytes[at]] ^ ...));
}

}  // namespace crc16_8408_tables

inline std::uint16_t crc16_8408(std::uint16_t crc, std::span<const std::uint8_t> bytes) {
    using namespace crc16_8408_tables;
    while (bytes.size() >= kSlice) {
        crc = of_slice(crc, bytes.data(), std::make_index_sequence<kSlice>());
        bytes = bytes.subspan(kSlice);
    }
    for (const std::uint8_t byte : bytes) {
        crc = static_cast<std::uint16_t>(crc >> 8U ^ kTables[0][(crc ^ byte) & 0xFFU]);
    }
    return crc;
}

}  // namespace tribus
