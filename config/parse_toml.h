#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "config/document.h"

namespace tribus {

/// The first place where a text is not TOML.
struct SyntaxError {
    Location where;
    std::string text;    ///< the library's words, or
    bool whole = false;  ///< a sentence of our own
};

/// The one place that sees the TOML library. Any bytes are allowed.
tl::expected<Table, SyntaxError> parse_toml(std::string_view text);

}  // namespace tribus
