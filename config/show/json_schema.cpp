#include "config/show/json_schema.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "config/keys/keys.h"
#include "config/keys/words.h"
#include "config/show/json_schema_values.h"
#include "core/channel_frame.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kNamePattern = "^[A-Za-z0-9_-]+$";
constexpr std::string_view kChannelPattern = "^([1-9]|1[0-8])$";
static_assert(kChannelCount == 18, "the pattern of channel numbers says so");

Json key_schema(const Key& key);

Json closed_object() {
    return {{"type", "object"}, {"additionalProperties", false}};
}

Json by_channel(Json value) {
    Json json = closed_object();
    json["patternProperties"][std::string(kChannelPattern)] = std::move(value);
    return json;
}

Json properties(std::span<const Key> keys) {
    Json json = Json::object();
    for (const Key& key : keys) {
        json[std::string(key.name())] = key_schema(key);
    }
    return json;
}

Json table_schema(std::span<const Key> keys) {
    Json json = closed_object();
    json["properties"] = properties(keys);
    for (const Key& key : keys) {
        if (key.setting.required) {
            json["required"].push_back(key.name());
        }
    }
    return json;
}

/// Names of the keys that at least one protocol defines.
std::set<std::string> own_key_names(SettingScope scope) {
    std::set<std::string> names;
    for (const Protocol* protocol : protocols()) {
        for (const Key& key : protocol_keys(*protocol, scope)) {
            names.emplace(key.name());
        }
    }
    return names;
}

/// Schema for tables with that protocol: allows its keys and forbids those of other protocols.
Json protocol_branch(const Protocol& protocol, SettingScope scope) {
    const auto keys = protocol_keys(protocol, scope);
    Json own = properties(keys);
    for (const std::string& name : own_key_names(scope)) {
        if (!own.contains(name)) {
            own[name] = false;
        }
    }
    Json json = Json::object();
    json["if"]["properties"]["protocol"]["const"] = protocol.name;
    json["if"]["required"] = {"protocol"};
    json["then"]["properties"] = std::move(own);
    for (const Key& key : keys) {
        if (key.setting.required) {
            json["then"]["required"].push_back(key.name());
        }
    }
    const auto media = media_for(protocol);
    for (std::size_t i = 0; media.size() > 1 && i < media.size(); ++i) {
        json["then"]["oneOf"].push_back({{"required", Json::array({media[i]->place.key})}});
    }
    return json;
}

Json port_schema(const Key& tables) {
    Json json = table_schema(tables.inside);
    for (const std::string& name : own_key_names(*tables.protocol_scope)) {
        json["properties"][name] = true;
    }
    json["properties"]["protocol"]["enum"] = protocol_names(*tables.protocol_scope);
    json["allOf"] = Json::array();
    for (const Protocol* protocol : protocols()) {
        if (protocol->goes(*tables.protocol_scope)) {
            json["allOf"].push_back(protocol_branch(*protocol, *tables.protocol_scope));
        }
    }
    return json;
}

Json named_tables_schema(const Key& key) {
    Json json = closed_object();
    json["patternProperties"][std::string(kNamePattern)] =
        key.protocol_scope ? port_schema(key) : table_schema(key.inside);
    return json;
}

Json names_schema() {
    const Json name = {{"type", "string"}, {"pattern", kNamePattern}};
    Json list = {{"type", "array"}, {"items", name}, {"minItems", 1}, {"uniqueItems", true}};
    return {{"anyOf", Json::array({name, std::move(list)})}};
}

Json presets_schema() {
    const Json pulse = {{"type", "number"}, {"minimum", kLeastPulse}, {"maximum", kMostPulse}};
    Json json = by_channel(pulse);
    json["properties"][std::string(kOtherChannels)] = pulse;
    return json;
}

Json weights_schema() {
    Json json =
        by_channel({{"type", "number"}, {"minimum", -kMostWeight}, {"maximum", kMostWeight}});
    json["minProperties"] = 1;
    return json;
}

Json channels_schema(const Key& key) {
    const Json number = {{"type", "integer"}, {"minimum", 1}, {"maximum", kChannelCount}};
    Json table = table_schema(key.inside);
    for (const std::string_view source : channel_source_names()) {
        table["oneOf"].push_back({{"required", Json::array({source})}});
    }
    return by_channel({{"anyOf", Json::array({number, std::move(table)})}});
}

Json texts_schema() {
    const Json text = {{"type", "string"}, {"minLength", 1}};
    return {{"type", "object"}, {"additionalProperties", text}, {"minProperties", 1}};
}

Json line_schema() {
    const Json number = {{"type", "integer"}, {"minimum", 0}};
    const Json name = {{"type", "string"}, {"minLength", 1}};
    return {{"anyOf", Json::array({number, name})}};
}

Json shape_schema(const Key& key) {
    switch (key.kind) {
        case KeyKind::value:
            break;
        case KeyKind::protocol:
            return {{"enum", protocol_names()}};
        case KeyKind::names:
            return names_schema();
        case KeyKind::presets:
            return presets_schema();
        case KeyKind::weights:
            return weights_schema();
        case KeyKind::list:
            return {{"type", "array"}, {"items", table_schema(key.inside)}};
        case KeyKind::table:
            return table_schema(key.inside);
        case KeyKind::named_tables:
            return named_tables_schema(key);
        case KeyKind::texts:
            return texts_schema();
        case KeyKind::line:
            return line_schema();
        case KeyKind::channels:
            return channels_schema(key);
    }
    return value_schema(key);
}

Json key_schema(const Key& key) {
    Json json = {{"description", help_with_default(key.setting)}};
    json.update(shape_schema(key));
    return json;
}

}  // namespace

std::string json_schema() {
    Json json = {{"$schema", "http://json-schema.org/draft-07/schema#"},
                 {"title", "Configuration of tribus"}};
    json.update(table_schema(root_keys()));
    return json.dump(2) + "\n";
}

}  // namespace tribus
