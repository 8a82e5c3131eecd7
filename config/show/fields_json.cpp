#include "config/show/fields_json.h"

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>

#include <nlohmann/json.hpp>

#include "config/schema/notation.h"

namespace tribus {

namespace {

using Json = nlohmann::ordered_json;

Json points_json(const TwoPoints& points) {
    Json json = Json::object();
    json["raw"] = {number_json(points.raw[0]), number_json(points.raw[1])};
    json["us"] = {number_json(points.microseconds[0]), number_json(points.microseconds[1])};
    return json;
}

Json tree_json(const SettingTree& tree) {
    return std::visit(
        [](const auto& content) -> Json {
            using Content = std::decay_t<decltype(content)>;
            if constexpr (std::is_same_v<Content, SettingTree::List>) {
                Json json = Json::array();
                for (const SettingTree& item : content) {
                    json.push_back(tree_json(item));
                }
                return json;
            } else if constexpr (std::is_same_v<Content, SettingTree::Table>) {
                Json json = Json::object();
                for (const SettingEntry& entry : content) {
                    json[entry.key] = tree_json(entry.value);
                }
                return json;
            } else {
                return content;
            }
        },
        tree.content);
}

}  // namespace

Json number_json(double number) {
    constexpr double kExact = 1e15;
    if (number == std::floor(number) && std::abs(number) < kExact) {
        return static_cast<std::int64_t>(number);
    }
    return number;
}

Json value_json(SettingType type, const SettingValue& value) {
    return std::visit(
        [type](const auto& content) -> Json {
            using Content = std::decay_t<decltype(content)>;
            if constexpr (std::is_same_v<Content, Duration>) {
                return format_duration(content);
            } else if constexpr (std::is_same_v<Content, NumberRange>) {
                return Json::array({number_json(content.low), number_json(content.high)});
            } else if constexpr (std::is_same_v<Content, TwoPoints>) {
                return points_json(content);
            } else if constexpr (std::is_same_v<Content, SettingFile> ||
                                 std::is_same_v<Content, KeyFile>) {
                return content.path;
            } else if constexpr (std::is_same_v<Content, SettingTree>) {
                return tree_json(content);
            } else if constexpr (std::is_same_v<Content, double>) {
                return type == SettingType::slew ? Json(format_slew(content))
                                                 : number_json(content);
            } else {
                return content;
            }
        },
        value);
}

Json values_json(const SettingValues& values, std::span<const Key> keys) {
    Json json = Json::object();
    for (const Key& key : keys) {
        if (const SettingValue* value = values.find(key.name())) {
            json[std::string(key.name())] = value_json(key.setting.type, *value);
        }
    }
    return json;
}

Json members_json(const void* object, const char* owner, std::span<const Key> keys) {
    Json json = Json::object();
    for (const Key& key : keys) {
        const auto value = key.field.owner == owner ? key.field.get(object) : std::nullopt;
        if (value) {
            json[std::string(key.name())] = value_json(key.setting.type, *value);
        }
    }
    return json;
}

Json in_order_of_rows(const Json& json, std::span<const Key> keys,
                      const std::function<bool(std::string_view key)>& wanted) {
    Json ordered = Json::object();
    for (const Key& key : keys) {
        const auto found = json.find(key.name());
        if (found != json.end() && wanted(key.name())) {
            ordered[std::string(key.name())] = *found;
        }
    }
    for (const auto& [key, value] : json.items()) {
        if (!ordered.contains(key) && wanted(key)) {
            ordered[key] = value;
        }
    }
    return ordered;
}

}  // namespace tribus
