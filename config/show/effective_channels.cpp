#include "config/show/effective_channels.h"

#include <cmath>
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

std::int64_t number_of(std::size_t channel) {
    return static_cast<std::int64_t>(channel) + 1;
}

void set_pulse(SettingValues& values, std::string_view key, const std::optional<Pulse>& pulse) {
    if (pulse) {
        values.set(key, pulse->microseconds());
    }
}

void set_range(SettingValues& values, std::string_view key,
               const std::optional<PulseRange>& range) {
    if (range) {
        values.set(key, NumberRange{range->low.microseconds(), range->high.microseconds()});
    }
}

Json mix_json(const Mix& mix) {
    Json json = Json::object();
    for (const MixTerm& term : mix.terms) {
        json[std::to_string(number_of(term.channel))] = number_json(term.weight);
    }
    return json;
}

void set_shape(SettingValues& values, const ChannelRule& rule) {
    values.set("reverse", rule.reverse);
    values.set("trim", rule.trim.microseconds());
    values.set("expo", rule.expo);
    values.set("deadband", rule.deadband.microseconds());
    if (rule.slew_us_per_second) {
        values.set("slew", *rule.slew_us_per_second);
    }
    set_pulse(values, "min", rule.min);
    set_pulse(values, "max", rule.max);
}

bool unshaped(const ChannelRule& rule) {
    return !rule.reverse && rule.trim == Pulse{} && rule.expo == 0 && rule.deadband == Pulse{} &&
           !rule.slew_us_per_second && !rule.min && !rule.max;
}

}  // namespace

Json number_json(double number) {
    constexpr double kExact = 1e15;
    if (number == std::floor(number) && std::abs(number) < kExact) {
        return static_cast<std::int64_t>(number);
    }
    return number;
}

namespace {

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
            } else if constexpr (std::is_same_v<Content, SettingFile>) {
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

Json value_rule_json(const ValueRule& rule) {
    SettingValues values;
    if (rule.all_zero) {
        values.set("all_zero", true);
    } else {
        values.set("channel", number_of(rule.channel));
    }
    set_pulse(values, "below", rule.below);
    set_pulse(values, "above", rule.above);
    set_range(values, "between", rule.between);
    return values_json(values, loss_rule_keys());
}

Json channel_json(const ChannelRule& rule, std::span<const LineConfig> lines) {
    SettingValues values;
    const auto* from = std::get_if<FromChannel>(&rule.source);
    if (from != nullptr && unshaped(rule)) {
        return number_of(from->channel);
    }
    if (const auto* fixed = std::get_if<Fixed>(&rule.source)) {
        values.set("fixed", fixed->pulse.microseconds());
    } else if (const auto* line = std::get_if<FromLine>(&rule.source)) {
        values.set("line", lines[line->line].name);
    } else if (const auto* limits = std::get_if<Switch>(&rule.source)) {
        values.set("from", number_of(limits->channel));
        set_pulse(values, "above", limits->above);
        set_pulse(values, "below", limits->below);
    } else {
        set_shape(values, rule);
        if (from != nullptr) {
            values.set("from", number_of(from->channel));
        }
    }
    Json json = values_json(values, channel_keys());
    if (const auto* mix = std::get_if<Mix>(&rule.source)) {
        Json mixed = {{"mix", mix_json(*mix)}};
        mixed.update(json);
        return mixed;
    }
    return json;
}

}  // namespace tribus
