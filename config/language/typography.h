#pragma once

#include <string>
#include <string_view>

#include "config/language/mistakes.h"

namespace tribus {

/// Replaces characters that text processors and web pages put where a program expects others:
/// typographic quotes, no-break spaces, dashes before numbers, characters without a width, line
/// separators. Each kind is one mistake, however often it occurs. What stands inside quotes and
/// comments stays. `text` must be valid UTF-8. Returns `text`, or `converted`, which is written
/// only for a text that is not ASCII alone.
std::string_view with_plain_characters(std::string_view text, std::string& converted,
                                       Mistakes& mistakes);

}  // namespace tribus
