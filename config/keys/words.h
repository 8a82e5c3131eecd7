#pragma once

#include <string>
#include <string_view>

#include "config/keys/keys.h"

/// Words about the rows of the key table. Pure.
namespace tribus {

/// One key as the manual shows it. Keys and values stand in backticks, but for `example`.
struct KeyWords {
    std::string type;      ///< "duration"
    std::string range;     ///< `"5ms"` to `"10s"`; empty: the type says all
    std::string fallback;  ///< what holds where the key is left out, or "required"
    std::string meaning;   ///< sentences, with the last full stop
    std::string example;   ///< `key = value` as in a file
};

/// `way`: whether the key stands in an input or in an output, which know different protocols.
KeyWords words_of(const Key& key, SettingScope way = SettingScope::both);

/// The help of a row, followed by what holds where the key is left out.
std::string help_with_default(const Setting& setting);

/// For media that show backticks as they are.
std::string without_backticks(std::string_view text);

}  // namespace tribus
