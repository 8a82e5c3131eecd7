#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "app/web/http/http.h"
#include "app/web/pairing/pairing.h"

/// Forms of answers, and what requests carry. Pure.
namespace tribus::web {

using Json = nlohmann::ordered_json;

HttpAnswer json_answer(const Json& json, int status = 200);
/// `{"error": why}`.
HttpAnswer refused(int status, std::string_view why, bool keeps_open = true);
/// The daemon's own words; its errors become 502.
HttpAnswer as_it_is(const std::string& json);

/// A member of the JSON object in a body; nothing if it is absent or of another type.
std::optional<std::string> text_in(const std::string& body, const char* name);
std::optional<std::int64_t> number_in(const std::string& body, const char* name);

/// The present time.
WallTime wall_now();

}  // namespace tribus::web
