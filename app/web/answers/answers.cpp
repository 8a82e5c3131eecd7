#include "app/web/answers/answers.h"

#include <chrono>
#include <cstdint>

#include "app/cli/object_text.h"
#include "app/client/parse_json.h"
#include "app/client/status_fields.h"
#include "pipelines/realtime/clock.h"

namespace tribus::web {
namespace {

/// Null if the body is no object, or has no such member.
Json member(const std::string& body, const char* name) {
    const Json json = parse_json_as<Json>(body);
    const auto found = json.is_object() ? json.find(name) : json.end();
    return found == json.end() ? Json() : *found;
}

}  // namespace

HttpAnswer json_answer(const Json& json, int status) {
    return {.status = status, .content = json_text(json)};
}

HttpAnswer refused(int status, std::string_view why, bool keeps_open) {
    HttpAnswer answer = json_answer({{"error", std::string(why)}}, status);
    answer.keeps_open = keeps_open;
    return answer;
}

HttpAnswer as_it_is(const std::string& json) {
    const auto parsed = parse_json(json);
    if (!parsed.is_object()) {
        return refused(502, "the daemon did not answer with an object");
    }
    if (status_fields::text(parsed, "type") == "error") {
        return refused(502, status_fields::text(parsed, "error"));
    }
    return {.content = json};
}

std::optional<std::string> text_in(const std::string& body, const char* name) {
    const Json value = member(body, name);
    return value.is_string() ? std::optional(value.get<std::string>()) : std::nullopt;
}

std::optional<std::int64_t> number_in(const std::string& body, const char* name) {
    const Json value = member(body, name);
    return value.is_number_integer() ? std::optional(value.get<std::int64_t>()) : std::nullopt;
}

WallTime wall_now() {
    return std::chrono::duration_cast<WallTime>(wall_time_now());
}

}  // namespace tribus::web
