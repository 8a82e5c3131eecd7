#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

/// CRC-16 of SRXL (docs/protocols/srxl.md, "Frame"): polynomial 1021, start 0, most significant bit
/// first. The same as crc16_1021(0, ...), without loops over single bytes. Pure and reentrant.
namespace tribus::srxl_check {

inline constexpr std::size_t kSlice = 8;
using Table = std::array<std::uint16_t, 256>;

constexpr std::uint16_t shifted_by_a_byte(std::uint16_t crc) {
    constexpr unsigned kPolynomial = 0x1021;
    unsigned shifted = crc;
    for (int bit = 0; bit < 8; ++bit) {
        shifted = (shifted & 0x8000U) != 0 ? (shifted << 1U) ^ kPolynomial : shifted << 1U;
    }
    return static_cast<std::uint16_t>(shifted);
}

/// Table `n` has the effect of a byte that `n` further bytes follow.
inline constexpr std::array<Table, kSlice> kTables = [] {
    std::array<Table, kSlice> tables{};
    for (std::size_t byte = 0; byte < tables[0].size(); ++byte) {
        auto crc = static_cast<std::uint16_t>(byte << 8U);
        for (Table& table : tables) {
            crc = shifted_by_a_byte(crc);
            table[byte] = crc;
        }
    }
    return tables;
}();

template <std::size_t... at>
std::uint16_t of_slice(std::uint16_t crc, const std::uint8_t* bytes, std::index_sequence<at...>) {
    constexpr std::size_t kLast = sizeof...(at) - 1;
    const auto effect = [&](std::size_t position) {
        const unsigned before = position == 0 ? crc >> 8U : position == 1 ? crc & 0xFFU : 0U;
        return kTables[kLast - position][bytes[position] ^ before];
    };
    return static_cast<std::uint16_t>((effect(at) ^ ...));
}

/// The length is that of a frame without its check.
template <std::size_t count>
std::uint16_t crc_of(const std::uint8_t* bytes) {
    // The CRC before the first slice is 0, so that slice may have a single byte.
    constexpr std::size_t kFirst = (count - 1) % kSlice + 1;
    std::uint16_t crc = of_slice(0, bytes, std::make_index_sequence<kFirst>());
    for (std::size_t at = kFirst; at < count; at += kSlice) {
        crc = of_slice(crc, bytes + at, std::make_index_sequence<kSlice>());
    }
    return crc;
}

}  // namespace tribus::srxl_check
