#include "app/client/status_fields.h"

#include <algorithm>
#include <cstddef>

#include <nlohmann/json.hpp>

#include "app/cli/screen_parts.h"

namespace tribus::status_fields {

const Json& field(const Json& object, const char* key) {
    static const Json nothing;
    if (!object.is_object()) {
        return nothing;
    }
    const auto found = object.find(key);
    return found == object.end() ? nothing : *found;
}

std::string raw_text(const Json& object, const char* key) {
    const Json& value = field(object, key);
    return value.is_string() ? value.get<std::string>() : "";
}

std::string shown(std::string_view text) {
    std::string shown;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const std::size_t control = screen::control_length(text.substr(i));
        shown += control == 0 ? text[i] : '?';
        i += control == 0 ? 0 : control - 1;
    }
    return shown;
}

std::string text(const Json& object, const char* key) {
    return shown(raw_text(object, key));
}

std::optional<double> number(const Json& object, const char* key) {
    const Json& value = field(object, key);
    return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

std::optional<std::int64_t> whole(const Json& object, const char* key) {
    constexpr double kMost = 9007199254740992;
    const auto found = number(object, key);
    return found ? std::optional(static_cast<std::int64_t>(std::clamp(*found, -kMost, kMost)))
                 : std::nullopt;
}

std::uint64_t count(const Json& object, const char* key) {
    const Json& value = field(object, key);
    return value.is_number_unsigned() ? value.get<std::uint64_t>() : 0;
}

bool flag(const Json& object, const char* key) {
    const Json& value = field(object, key);
    return value.is_boolean() && value.get<bool>();
}

const Json& list(const Json& object, const char* key) {
    static const Json empty = Json::array();
    const Json& value = field(object, key);
    return value.is_array() ? value : empty;
}

}  // namespace tribus::status_fields
