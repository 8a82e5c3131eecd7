#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

/// What someone wrote, shown in a message of one line. Pure and reentrant.
namespace tribus {

/// In double quotes, on one line: control characters are escaped as TOML and JSON do. Of text that
/// is longer than `most` bytes only the characters within those are shown, and "..." behind.
std::string in_quotes(std::string_view text, std::size_t most = std::string_view::npos);
/// `"a", "b", "c"`
std::string in_quotes_all(std::span<const std::string_view> names);

}  // namespace tribus
