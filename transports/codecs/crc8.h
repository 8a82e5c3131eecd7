#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

/// CRC-8 of any polynomial, most significant bit first, no final XOR. Pure and reentrant.
namespace tribus {

namespace crc8_tables {

inline constexpr std::size_t kSlice = 8;
using CrcTable = std::array<std::uint8_t, 256>;

constexpr std::uint8_t shifted_by_a_byte(std::uint8_t crc, unsigned polynomial) {
    unsigned shifted = crc;
    for (int bit = 0; bit < 8; ++bit) {
        shifted = (shifted & 0x80U) != 0 ? (shifted << 1U) ^ polynomial : shifted << 1U;
    }
    return static_cast<std::uint8_t>(shifted);
}

/// Table `n` has the effect of a byte that `n` further bytes follow, so that a slice of bytes needs
/// no result of the byte before.
template <std::uint8_t polynomial>
inline constexpr std::array<CrcTable, kSlice> kTables = [] {
    std::array<CrcTable, kSlice> tables{};
    for (std::size_t byte = 0; byte < tables[0].size(); ++byte) {
        auto crc = static_cast<std::uint8_t>(byte);
        for (CrcTable& table : tables) {
            crc = shifted_by_a_byte(crc, polynomial);
            table[byte] = crc;
        }
    }
    return tables;
}();

template <std::uint8_t polynomial, std::size_t... at>
std::uint8_t of_slice(std::uint8_t crc, const std::uint8_t* bytes, std::index_sequence<at...>) {
    constexpr std::size_t kLast = sizeof...(at) - 1;
    return static_cast<std::uint8_t>(
        (kTables<polynomial>[kLast - at][at == 0 ? bytes[at] ^ crc : bytes[at]] ^ ...));
}

template <std::uint8_t polynomial, std::size_t count>
std::uint8_t of_bytes(std::uint8_t crc, const std::uint8_t* bytes) {
    return of_slice<polynomial>(crc, bytes, std::make_index_sequence<count>());
}

}  // namespace crc8_tables

/// The CRC of a number of bytes that is known, without loops.
template <std::uint8_t polynomial, std::size_t bytes_count>
[[gnu::always_inline]] inline std::uint8_t crc8(std::uint8_t start,
                                                std::span<const std::uint8_t, bytes_count> bytes) {
    using namespace crc8_tables;
    constexpr std::size_t kFirst = (bytes_count - 1) % kSlice + 1;
    std::uint8_t crc = of_bytes<polynomial, kFirst>(start, bytes.data());
    for (std::size_t at = kFirst; at < bytes_count; at += kSlice) {
        crc = of_bytes<polynomial, kSlice>(crc, bytes.data() + at);
    }
    return crc;
}

/// Inlined always: on garbage it is called for each false beginning.
template <std::uint8_t polynomial>
[[gnu::always_inline]] inline std::uint8_t crc8(std::uint8_t start,
                                                std::span<const std::uint8_t> bytes) {
    using namespace crc8_tables;
    std::uint8_t crc = start;
    const std::uint8_t* at = bytes.data();
    const std::uint8_t* const end = at + bytes.size();
    for (; end - at >= 8; at += 8) {
        crc = of_bytes<polynomial, 8>(crc, at);
    }
    if (end - at >= 4) {
        crc = of_bytes<polynomial, 4>(crc, at);
        at += 4;
    }
    for (; at != end; ++at) {
        crc = kTables<polynomial>[0][crc ^ *at];
    }
    return crc;
}

}  // namespace tribus
