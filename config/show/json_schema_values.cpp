#include "config/show/json_schema_values.h"

#include <charconv>
#include <string>
#include <string_view>
#include <variant>

#include <nlohmann/json.hpp>

#include "config/keys/keys.h"
#include "config/schema/notation.h"
#include "config/show/fields_json.h"

namespace tribus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kDurationPattern = R"(^[0-9]+(\.[0-9]+)?(us|ms|s)$)";
constexpr std::string_view kInterfacePattern = R"(^[^/:\s]{1,15}$)";
constexpr std::string_view kSlewPattern = R"(^[0-9]+(\.[0-9]+)?us/s$)";

Json number_schema(const Setting& setting) {
    Json json = {{"type", setting.type == SettingType::integer ? "integer" : "number"}};
    if (setting.least != 0 || setting.most != 0) {
        json["minimum"] = number_json(setting.least);
        json["maximum"] = number_json(setting.most);
    }
    return json;
}

Json choices_schema(const Setting& setting) {
    Json choices = Json::array();
    for (const std::string_view choice : setting.choices) {
        if (setting.type == SettingType::integer) {
            std::int64_t number = 0;
            std::from_chars(choice.data(), choice.data() + choice.size(), number);
            choices.push_back(number);
        } else {
            choices.push_back(choice);
        }
    }
    return {{"enum", std::move(choices)}};
}

Json pair_schema(Json items) {
    return {{"type", "array"}, {"items", std::move(items)}, {"minItems", 2}, {"maxItems", 2}};
}

Json scale_schema(const Setting& setting) {
    const Json raw = {{"type", "integer"}, {"minimum", 0}, {"maximum", number_json(kMostRaw)}};
    Json points = {{"type", "object"}, {"additionalProperties", false}};
    points["properties"]["raw"] = pair_schema(raw);
    points["properties"]["us"] = pair_schema({{"type", "number"}});
    points["required"] = {"raw", "us"};
    return {{"anyOf", Json::array({choices_schema(setting), std::move(points)})}};
}

Json type_schema(const Setting& setting) {
    switch (setting.type) {
        case SettingType::boolean:
            return {{"type", "boolean"}};
        case SettingType::integer:
            return setting.choices.empty() ? number_schema(setting) : choices_schema(setting);
        case SettingType::number:
        case SettingType::pulse:
            return number_schema(setting);
        case SettingType::pulses:
            return pair_schema(number_schema(setting));
        case SettingType::choice:
            return choices_schema(setting);
        case SettingType::duration:
            return {{"type", "string"}, {"pattern", kDurationPattern}};
        case SettingType::slew:
            return {{"type", "string"}, {"pattern", kSlewPattern}};
        case SettingType::scale:
            return scale_schema(setting);
        case SettingType::tree:
            return {{"type", "object"}};
        case SettingType::text:
            if (names_interface(setting)) {
                return {{"type", "string"}, {"pattern", kInterfacePattern}};
            }
            break;
        case SettingType::file:
        case SettingType::key_file:
            break;
    }
    return {{"type", "string"}, {"minLength", 1}};
}

}  // namespace

Json value_schema(const Key& key) {
    Json json = type_schema(key.setting);
    if (const auto value = default_of(key)) {
        json["default"] = value_json(key.setting.type, *value);
    }
    return json;
}

}  // namespace tribus
