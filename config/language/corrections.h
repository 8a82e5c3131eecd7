#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace tribus {

/// A part of a line outside of comments: a text with its quotes, a word, or one other character.
struct LinePart {
    std::size_t at = 0;  ///< in bytes from 0
    std::string_view text;
    bool in_quotes = false;
};

/// The parts of a line of TOML without the blanks between them. A text that does not end in the
/// line is one part. Pure.
std::vector<LinePart> parts_of_line(std::string_view line);

/// Other text for a part of a line whose intention is clear.
struct Correction {
    std::size_t at = 0;  ///< in bytes from 0
    std::size_t length = 0;
    std::string text;
    std::string message;  ///< what is wrong, and what to write instead
};

/// What a TOML parser would refuse in that line although the intention is clear: numbers in other
/// notations, backslashes that begin no escape, a comma before `}`. From left to right. Pure.
std::vector<Correction> corrections_in(std::string_view line);

/// The line with these corrections.
std::string corrected(std::string_view line, const std::vector<Correction>& corrections);

}  // namespace tribus
