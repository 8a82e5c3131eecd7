#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tribus {

/// A word that people use for protocols.
struct ProtocolWord {
    std::string_view word;  ///< prefix of the word, in small letters without punctuation
    std::array<std::string_view, 3> protocols;  ///< the likeliest first, then empty ones
};

std::span<const ProtocolWord> protocol_words();

/// A word without punctuation: "bit_rate" and "Bit-Rate" are "bitrate". Pure.
std::string small_letters_and_digits(std::string_view text);

/// The protocols that people mean by a word that is the name of none: a maker, a product, another
/// name, or the name of a protocol for the other direction. Only those in `allowed`, the likeliest
/// first. Pure.
std::vector<std::string_view> protocols_meant(std::string_view word,
                                              std::span<const std::string_view> allowed);

/// Hint for a word that is no name of a protocol: `did you mean "crsf"? Allowed: ...`, by what
/// people mean, else by the nearest name.
std::string protocol_suggestion(std::string_view wrong, std::span<const std::string_view> allowed);

}  // namespace tribus
