#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>

#include "transports/codecs/wire_words.h"

/// Sums of bytes, eight at a time. Pure and reentrant.
namespace tribus::byte_sums {

// Four words of 16 bits side by side.
inline constexpr std::size_t kGroupBytes = sizeof(std::uint64_t);
inline constexpr std::uint64_t kLowBytes = 0x00FF00FF'00FF00FF;
inline constexpr std::uint64_t kEachWord = 0x00010001'00010001;

inline std::uint64_t sum_by_words(std::uint64_t bytes) {
    return (bytes & kLowBytes) + ((bytes >> 8U) & kLowBytes);
}
/// Sum of the four words, which must be less than 2^16.
inline unsigned total(std::uint64_t words) {
    return static_cast<unsigned>((words * kEachWord) >> 48U);
}

/// Sum of at most 64 bytes.
inline unsigned sum_of(std::span<const std::uint8_t> bytes) {
    std::uint64_t words = 0;
    for (; bytes.size() >= kGroupBytes; bytes = bytes.subspan(kGroupBytes)) {
        words += sum_by_words(load_word(bytes.data()));
    }
    return std::accumulate(bytes.begin(), bytes.end(), total(words));
}
/// The same for a number of bytes that is known, without loops.
template <std::size_t count>
unsigned sum_of(std::span<const std::uint8_t, count> bytes) {
    static_assert(count >= kGroupBytes && count <= 64);
    constexpr std::size_t kRest = count % kGroupBytes;
    std::uint64_t words = 0;
    for (std::size_t at = 0; at + kGroupBytes <= count; at += kGroupBytes) {
        words += sum_by_words(load_word(&bytes[at]));
    }
    if constexpr (kRest != 0) {
        // The upper bytes of the last eight; the lower ones are counted already.
        const std::uint64_t last = load_word(&bytes[count - kGroupBytes]);
        words += sum_by_words(last >> (8U * (kGroupBytes - kRest)));
    }
    return total(words);
}

}  // namespace tribus::byte_sums
