#include "app/inspect/value_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "config/show/fields_json.h"

namespace tribus {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::string_view kFrom = "from";

std::string channel_numbered(const OrderedJson& number) {
    return "channel " + number.dump();
}

bool is_default(const Key& key, const OrderedJson& value) {
    const auto fallback = default_of(key);
    return fallback && value_json(key.setting.type, *fallback) == value;
}

std::string_view unit_of(const Setting& setting) {
    const bool is_pulse = setting.type == SettingType::pulse || setting.type == SettingType::pulses;
    return is_pulse ? "us" : setting.unit;
}

std::string row_text(const Key& key, const OrderedJson& value) {
    if (value == OrderedJson(true)) {
        return std::string(key.name());
    }
    const std::string_view unit = unit_of(key.setting);
    return fmt::format("{} {}{}{}", key.name(), plain_text(value), unit.empty() ? "" : " ", unit);
}

}  // namespace

std::string plain_text(const OrderedJson& value) {
    if (value.is_string()) {
        return value.get<std::string>();
    }
    if (value.is_object()) {
        std::string text;
        for (const auto& [key, inner] : value.items()) {
            text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", key, plain_text(inner));
        }
        return "{ " + text + " }";
    }
    return value.dump();
}

std::vector<std::string> row_texts(const OrderedJson& table, std::span<const Key> rows) {
    std::vector<std::string> texts;
    for (const Key& row : rows) {
        const auto value = table.find(row.name());
        if (value != table.end() && !is_default(row, *value)) {
            texts.push_back(row_text(row, *value));
        }
    }
    return texts;
}

std::string channel_text(const OrderedJson& rule) {
    if (rule.is_number()) {
        return channel_numbered(rule);
    }
    OrderedJson steps = rule;
    std::vector<std::string> texts;
    if (const auto from = steps.find(kFrom); from != steps.end()) {
        texts.push_back(channel_numbered(*from));
        steps.erase(from);
    }
    for (std::string& text : row_texts(steps, channel_keys())) {
        texts.push_back(std::move(text));
    }
    return fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace tribus
