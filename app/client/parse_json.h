#pragma once

#include <cstddef>
#include <string_view>

#include <nlohmann/json.hpp>

namespace tribus {

/// Whether brackets are nested deeper than in anything that tribus programs tell each other. Pure.
inline bool is_nested_too_deep(std::string_view json) {
    constexpr int kDeepest = 32;
    int depth = 0;
    bool in_text = false;
    for (std::size_t i = 0; i < json.size() && depth <= kDeepest; ++i) {
        const char sign = json[i];
        if (in_text && sign == '\\') {
            ++i;
        } else if (sign == '"') {
            in_text = !in_text;
        } else if (!in_text) {
            depth += sign == '[' || sign == '{' ? 1 : sign == ']' || sign == '}' ? -1 : 0;
        }
    }
    return depth > kDeepest;
}

/// Parses what another program sent. `is_discarded` if it is no JSON, or nested too deep: copies of
/// a deep tree need a stack as deep. Pure.
template <class Json>
Json parse_json_as(std::string_view text) {
    return is_nested_too_deep(text) ? Json(Json::value_t::discarded)
                                    : Json::parse(text, nullptr, false);
}

inline nlohmann::json parse_json(std::string_view text) {
    return parse_json_as<nlohmann::json>(text);
}

}  // namespace tribus
