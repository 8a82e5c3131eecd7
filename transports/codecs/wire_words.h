#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

/// Eight bytes of a wire at once, the first byte lowest, whatever the machine's own order is.
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

/// Four numbers side by side in each word, the first lowest, and back.
template <std::size_t Words>
std::array<std::uint16_t, 4 * Words> from_words(const std::array<std::uint64_t, Words>& words) {
    if constexpr (std::endian::native == std::endian::little) {
        return std::bit_cast<std::array<std::uint16_t, 4 * Words>>(words);
    }
    std::array<std::uint16_t, 4 * Words> numbers{};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        numbers[i] = static_cast<std::uint16_t>(words[i / 4] >> (16U * (i % 4)));
    }
    return numbers;
}
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

}  // namespace tribus
