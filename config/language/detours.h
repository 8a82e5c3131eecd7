#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tribus {

/// The lines of a text, without their ends.
using Lines = std::vector<std::string>;

/// Prefix of the table that replaces a header which could not be read.
inline constexpr std::string_view kLostTable = "lost table of line ";

/// One way to continue after a mistake of syntax: other text for the lines from `first` (counted
/// from 0).
struct Detour {
    std::size_t first = 0;
    Lines replacement;
    bool loses_text = false;
    std::string text;  ///< what is wrong, if the detour shows it
    /// Place of the mistake in the line `first`. Absent: where the parser stopped.
    std::optional<unsigned> column{};
};

/// Detours around a mistake in that line (counted from 0), those with the smallest change first.
std::vector<Detour> detours_around(const Lines& lines, std::size_t line);

/// Without blanks at both ends.
std::string_view trimmed(std::string_view text);
/// A letter, digit, `_` or `-`.
bool is_word(char c);
/// Whether the line begins with `[`.
bool is_header(std::string_view line);

}  // namespace tribus
