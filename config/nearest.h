#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace tribus {

/// How many slips of the finger lie between two words: a letter too many, too few, wrong, or two
/// neighbours swapped (Damerau and Levenshtein). Upper and lower case count as equal. Pure.
std::size_t slips_between(std::string_view a, std::string_view b);

/// The candidate that `wrong` was most likely meant to be, the first of equals; nothing where all
/// are too far: more than a third of the longer word, at least one slip, never all of it.
std::optional<std::string_view> nearest(std::string_view wrong,
                                        std::span<const std::string_view> candidates);

}  // namespace tribus
