#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "app/screen_parts.h"

/// How a monitor reads what a daemon tells, which may be another version, or no daemon at all: a
/// field that is not there, or of another kind, is nothing. Pure.
namespace tribus::monitor {

using Json = nlohmann::json;

inline const Json& field(const Json& object, const char* key) {
    static const Json nothing;
    if (!object.is_object()) {
        return nothing;
    }
    const auto found = object.find(key);
    return found == object.end() ? nothing : *found;
}

/// As it was told, whatever is in it.
inline std::string raw_text(const Json& object, const char* key) {
    const Json& value = field(object, key);
    return value.is_string() ? value.get<std::string>() : "";
}

/// To be shown: control characters, which a terminal would obey, are question marks.
inline std::string shown(std::string_view text) {
    std::string shown;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const std::size_t control = screen::control_length(text.substr(i));
        shown += control == 0 ? text[i] : '?';
        i += control == 0 ? 0 : control - 1;
    }
    return shown;
}
inline std::string text(const Json& object, const char* key) {
    return shown(raw_text(object, key));
}

inline std::optional<double> number(const Json& object, const char* key) {
    const Json& value = field(object, key);
    return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

/// Zero where there is none.
inline std::uint64_t count(const Json& object, const char* key) {
    const Json& value = field(object, key);
    return value.is_number_unsigned() ? value.get<std::uint64_t>() : 0;
}

inline bool flag(const Json& object, const char* key) {
    const Json& value = field(object, key);
    return value.is_boolean() && value.get<bool>();
}

/// Empty where there is none.
inline const Json& list(const Json& object, const char* key) {
    static const Json empty = Json::array();
    const Json& value = field(object, key);
    return value.is_array() ? value : empty;
}

}  // namespace tribus::monitor
