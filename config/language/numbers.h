#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "config/language/document.h"

namespace tribus {

/// A number that TOML refuses, in the notation of TOML.
struct NumberRepair {
    std::string number;
    std::string_view rule;  ///< "a number does not begin with 0"
};

/// The valid number that is meant by a word that TOML refuses: "0115200", ".3", "5.", "0X300".
/// `nullopt` for other words. Pure.
std::optional<NumberRepair> repaired_number(std::string_view word);

/// The number, `true` or `false` that a text consists of. `nullopt` if it is another text. Pure.
std::optional<Value> value_in_text(const Value& value);

/// That number, `true` or `false` as it should stand in the file.
std::string bare_text(const Value& value);

/// For a message about a value of the wrong type: ", without quotes" if it is such a text, or a
/// list that has one.
std::string_view without_quotes_hint(const Value& value);

}  // namespace tribus
