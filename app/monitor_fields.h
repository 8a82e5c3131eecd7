#pragma once

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

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
inline std::string shown(std::string text) {
    constexpr unsigned char kBlank = 0x20;
    constexpr unsigned char kDelete = 0x7F;
    std::ranges::replace_if(
        text, [](unsigned char c) { return c < kBlank || c == kDelete; }, '?');
    return text;
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
