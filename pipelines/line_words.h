#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

/// What GPIO lines say and show, as words with a bit for each line. Lines are numbered in the order
/// of the configuration. Two words are aligned as one of twice the size, so that threads can
/// exchange them at once.
namespace tribus {

/// As many as a word has bits; no board has as many to spare.
inline constexpr std::size_t kMostLines = 32;

constexpr std::uint32_t line_bit(std::size_t line) {
    return std::uint32_t{1} << line;
}

/// Of the input lines, debounced.
struct alignas(8) LineLevels {
    std::uint32_t active = 0;
    /// It can be read. Of others, `active` is 0.
    std::uint32_t known = 0;

    void set(std::size_t line, std::optional<bool> level) {
        known = level ? known | line_bit(line) : known & ~line_bit(line);
        active = level.value_or(false) ? active | line_bit(line) : active & ~line_bit(line);
    }
    /// Nothing where it cannot be read.
    std::optional<bool> of(std::size_t line) const {
        return (known & line_bit(line)) == 0 ? std::nullopt
                                             : std::optional((active & line_bit(line)) != 0);
    }
    bool operator==(const LineLevels&) const = default;
};

/// All are there and none is active: so it is where nobody reads lines, as in a simulation.
inline constexpr LineLevels kNoLineActive{0, UINT32_MAX};

/// What output lines are to show: on, off, or blinking.
struct alignas(8) LineStates {
    std::uint32_t on = 0;
    std::uint32_t blinking = 0;

    bool operator==(const LineStates&) const = default;
};

}  // namespace tribus
