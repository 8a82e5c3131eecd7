#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

/// Quotes a user's text in a message of one line. Pure and reentrant.
namespace tribus {

/// `text` in double quotes on one line, with control characters escaped as in TOML and JSON,
/// and bytes that are not UTF-8 as `\xff`. A text
/// longer than `most` bytes is cut at a whole character and followed by "...".
std::string in_quotes(std::string_view text, std::size_t most = std::string_view::npos);
/// `"a", "b", "c"`
std::string in_quotes_all(std::span<const std::string_view> names);

}  // namespace tribus
