#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

/// Converts between machine order and wire order, in which the first byte is the lowest.
namespace tribus {

inline std::uint64_t in_wire_order(std::uint64_t word) {
    if constexpr (std::endian::native == std::endian::big) {
        return __builtin_bswap64(word);
    }
    return word;
}

inline std::uint64_t load_word(const std::uint8_t* wire) {
    std::uint64_t word = 0;
    std::memcpy(&word, wire, sizeof word);
    return in_wire_order(word);
}

inline void store_word(std::uint8_t* wire, std::uint64_t word) {
    word = in_wire_order(word);
    std::memcpy(wire, &word, sizeof word);
}

inline std::uint32_t load_half_word(const std::uint8_t* wire) {
    std::uint32_t half_word = 0;
    std::memcpy(&half_word, wire, sizeof half_word);
    return std::endian::native == std::endian::big ? __builtin_bswap32(half_word) : half_word;
}

inline void store_half_word(std::uint8_t* wire, std::uint32_t half_word) {
    if constexpr (std::endian::native == std::endian::big) {
        half_word = __builtin_bswap32(half_word);
    }
    std::memcpy(wire, &half_word, sizeof half_word);
}

/// The same with the highest byte first.
inline std::uint64_t load_word_highest_first(const std::uint8_t* wire) {
    return __builtin_bswap64(load_word(wire));
}
inline std::uint32_t load_half_word_highest_first(const std::uint8_t* wire) {
    return __builtin_bswap32(load_half_word(wire));
}

/// Four numbers in each word, the first one lowest.
template <std::size_t Numbers>
std::array<std::uint64_t, Numbers / 4> to_words(const std::array<std::uint16_t, Numbers>& numbers) {
    static_assert(Numbers % 4 == 0);
    if constexpr (std::endian::native == std::endian::little) {
        return std::bit_cast<std::array<std::uint64_t, Numbers / 4>>(numbers);
    }
    std::array<std::uint64_t, Numbers / 4> words{};
    for (std::size_t i = 0; i < Numbers; ++i) {
        words[i / 4] |= std::uint64_t{numbers[i]} << (16U * (i % 4));
    }
    return words;
}

/// Vector of eight 16-bit numbers (GCC and Clang extension).
using Lanes [[gnu::vector_size(16)]] = std::uint16_t;
using SignedLanes [[gnu::vector_size(16)]] = std::int16_t;
using PairLanes [[gnu::vector_size(16)]] = std::uint32_t;
using GroupLanes [[gnu::vector_size(16)]] = std::uint64_t;
constexpr std::size_t kLanes = sizeof(Lanes) / sizeof(std::uint16_t);

/// Numbers in memory order. `load_half_lanes` reads four numbers and sets the others to 0,
/// `store_half_lanes` writes the first four.
inline SignedLanes load_lanes(const void* numbers) {
    SignedLanes lanes;
    std::memcpy(&lanes, numbers, sizeof lanes);
    return lanes;
}
inline void store_numbers(void* numbers, SignedLanes lanes) {
    std::memcpy(numbers, &lanes, sizeof lanes);
}
inline SignedLanes load_half_lanes(const void* numbers) {
    using Halves [[gnu::vector_size(16)]] = std::uint64_t;
    std::uint64_t half = 0;
    std::memcpy(&half, numbers, sizeof half);
    return reinterpret_cast<SignedLanes>(Halves{half, 0});
}

inline void store_half_lanes(void* numbers, Lanes lanes) {
    std::memcpy(numbers, &lanes, sizeof lanes / 2);
}

/// Sum of the eight lanes modulo 2^16: adds halves, then quarters, then the rest.
inline std::uint16_t total(Lanes lanes) {
    lanes += __builtin_shufflevector(lanes, lanes, 4, 5, 6, 7, 6, 7, 6, 7);
    lanes += __builtin_shufflevector(lanes, lanes, 2, 3, 0, 1, 6, 7, 4, 5);
    return static_cast<std::uint16_t>(lanes[0] + lanes[1]);
}

/// Eight numbers in wire order, the low byte first.
inline Lanes in_wire_order(Lanes lanes) {
    if constexpr (std::endian::native == std::endian::big) {
        return lanes << 8U | lanes >> 8U;
    }
    return lanes;
}
inline SignedLanes load_wire(const std::uint8_t* wire) {
    return reinterpret_cast<SignedLanes>(in_wire_order(reinterpret_cast<Lanes>(load_lanes(wire))));
}
inline void store_wire(std::uint8_t* wire, Lanes lanes) {
    store_numbers(wire, reinterpret_cast<SignedLanes>(in_wire_order(lanes)));
}

}  // namespace tribus
