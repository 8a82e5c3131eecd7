#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

/// Levels of GPIO lines as words with one bit for each line, numbered in the order of the
/// configuration. Two words are aligned as one of twice the size, so that threads can exchange them
/// atomically.
namespace tribus {

/// The number of bits in a word. No board has as many spare lines.
inline constexpr std::size_t kMostLines = 32;

constexpr std::uint32_t line_bit(std::size_t line) {
    return std::uint32_t{1} << line;
}

/// Debounced levels of the input lines.
struct alignas(8) LineLevels {
    std::uint32_t active = 0;
    /// The line can be read. If it cannot, its bit in `active` is 0.
    std::uint32_t known = 0;

    void set(std::size_t line, std::optional<bool> level) {
        known = level ? known | line_bit(line) : known & ~line_bit(line);
        active = level.value_or(false) ? active | line_bit(line) : active & ~line_bit(line);
    }
    /// `nullopt` if the line cannot be read.
    std::optional<bool> of(std::size_t line) const {
        return (known & line_bit(line)) == 0 ? std::nullopt
                                             : std::optional((active & line_bit(line)) != 0);
    }
    bool operator==(const LineLevels&) const = default;
};

/// Every line can be read and none is active: the levels where nobody reads lines (simulation).
inline constexpr LineLevels kNoLineActive{0, UINT32_MAX};

/// What the output lines show: on, off, or blinking.
struct alignas(8) LineStates {
    std::uint32_t on = 0;
    std::uint32_t blinking = 0;

    bool operator==(const LineStates&) const = default;
};

}  // namespace tribus
