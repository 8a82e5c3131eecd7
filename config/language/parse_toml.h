#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "config/language/document.h"

namespace tribus {

/// The first place at which a text is not TOML.
struct SyntaxError {
    Location where;
    std::string text;    ///< message of the library, or
    bool whole = false;  ///< our own complete message
};

/// Parses TOML. Only its source file sees the TOML library. Accepts any bytes.
tl::expected<Table, SyntaxError> parse_toml(std::string_view text);

}  // namespace tribus
