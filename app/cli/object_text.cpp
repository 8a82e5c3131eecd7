#include "app/cli/object_text.h"

#include <nlohmann/json.hpp>

namespace tribus {

void ObjectText::add(std::string_view key, const nlohmann::ordered_json& value) {
    open_member(key);
    append(value);
}

void ObjectText::open_member(std::string_view key) {
    text_ += text_.size() == 1 ? "\"" : ",\"";
    text_ += key;
    text_ += "\":";
}

/// Bytes that are not UTF-8, of file names for example, are replaced.
void ObjectText::append(const nlohmann::ordered_json& value) {
    text_ += json_text(value);
}

std::string json_text(const nlohmann::ordered_json& json) {
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string error_object(std::string_view text) {
    return json_text({{"type", "error"}, {"error", text}});
}

}  // namespace tribus
