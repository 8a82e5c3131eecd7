#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

/// CRC-8 of CRSF and GHST: polynomial D5, start 0, most significant bit first
/// (docs/protocols/crsf.md, "Frame"). Pure and reentrant.
namespace tribus {

namespace crc8_d5_tables {

inline constexpr std::size_t kSlice = 8;
using CrcTable = std::array<std::uint8_t, 256>;

constexpr std::uint8_t shifted_by_a_byte(std::uint8_t crc) {
    constexpr unsigned kPolynomial = 0xD5;
    unsigned shifted = crc;
    for (int bit = 0; bit < 8; ++bit) {
        shifted = (shifted & 0x80U) != 0 ? (shifted << 1U) ^ kPolynomial : shifted << 1U;
    }
    return static_cast<std::uint8_t>(shifted);
}

/// Table `n` has the effect of a byte that `n` further bytes follow, so that a slice of bytes needs
/// no result of the byte before.
inline constexpr std::array<CrcTable, kSlice> kTables = [] {
    std::array<CrcTable, kSlice> tables{};
    for (std::size_t byte = 0; byte < tables[0].size(); ++byte) {
        auto crc = static_cast<std::uint8_t>(byte);
        for (CrcTable& table : tables) {
            crc = shifted_by_a_byte(crc);
            table[byte] = crc;
        }
    }
    return tables;
}();

template <std::size_t... at>
std::uint8_t of_slice(std::uint8_t crc, const std::uint8_t* bytes, std::index_sequence<at...>) {
    constexpr std::size_t kLast = sizeof...(at) - 1;
    return static_cast<std::uint8_t>(
        (kTables[kLast - at][at == 0 ? bytes[at] ^ crc : bytes[at]] ^ ...));
}

}  // namespace crc8_d5_tables

/// The CRC of a number of bytes that is known, without loops.
template <std::size_t bytes_count>
std::uint8_t crc8_d5(std::span<const std::uint8_t, bytes_count> bytes) {
    using namespace crc8_d5_tables;
    constexpr std::size_t kFirst = (bytes_count - 1) % kSlice + 1;
    std::uint8_t crc = of_slice(0, bytes.data(), std::make_index_sequence<kFirst>());
    for (std::size_t at = kFirst; at < bytes_count; at += kSlice) {
        crc = of_slice(crc, bytes.data() + at, std::make_index_sequence<kSlice>());
    }
    return crc;
}

inline std::uint8_t crc8_d5(std::span<const std::uint8_t> bytes) {
    std::uint8_t crc = 0;
    for (const std::uint8_t byte : bytes) {
        crc = crc8_d5_tables::kTables[0][crc ^ byte];
    }
    return crc;
}

}  // namespace tribus
