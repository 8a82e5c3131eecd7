#pragma once

#include <string_view>

#include <nlohmann/json.hpp>

namespace tribus {

/// Parses what another program sent. `is_discarded` if it is no JSON, or nested deeper than what
/// tribus programs tell each other: copies of a deep tree need a stack as deep. Pure.
template <class Json>
Json parse_json_as(std::string_view text) {
    constexpr int kDeepest = 32;
    bool too_deep = false;
    Json json = Json::parse(
        text,
        [&](int depth, auto /*event*/, Json& /*parsed*/) {
            too_deep = too_deep || depth > kDeepest;
            return !too_deep;
        },
        false);
    return too_deep ? Json(Json::value_t::discarded) : json;
}

inline nlohmann::json parse_json(std::string_view text) {
    return parse_json_as<nlohmann::json>(text);
}

}  // namespace tribus
