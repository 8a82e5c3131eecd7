#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace tribus {

/// Number of typing errors between two words (Damerau-Levenshtein distance): a missing, additional
/// or wrong letter, or two neighbours swapped. Ignores upper and lower case. Pure.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate nearest to `wrong`, the first one of equals. `nullopt` if all differ by more than
/// a third of the longer word (at least one error is permitted) or in every letter.
std::optional<std::string_view> nearest(std::string_view wrong,
                                        std::span<const std::string_view> candidates);

}  // namespace tribus
