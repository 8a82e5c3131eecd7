#pragma once

#include <algorithm>
#include <cctype>
#include <string_view>

namespace tribus {

/// Whether a name has only letters, digits, '-', '_' and '.', and begins with none of '-' and '.'.
/// Such a name is no option and no path, and stands in an address, a header and a message as it is.
inline bool is_plain_name(std::string_view name) {
    return !name.empty() && name.front() != '-' && name.front() != '.' &&
           std::ranges::all_of(name, [](unsigned char c) {
               return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
           });
}

}  // namespace tribus
