#include "config/show/effective_channels.h"

#include <string>
#include <variant>

#include <nlohmann/json.hpp>

#include "config/show/fields_json.h"

namespace tribus {
namespace {

using Json = nlohmann::ordered_json;

std::int64_t number_of(std::size_t channel) {
    return static_cast<std::int64_t>(channel) + 1;
}

Json mix_json(const Mix& mix) {
    Json json = Json::object();
    for (const MixTerm& term : mix.terms) {
        json[std::to_string(number_of(term.channel))] = number_json(term.weight);
    }
    return json;
}

}  // namespace

Json value_rule_json(const ValueRule& rule) {
    if (rule.all_zero) {
        return {{"all_zero", true}};
    }
    Json json = fields_json(rule, loss_rule_keys());
    json.erase("all_zero");
    return json;
}

Json channel_json(const ChannelRule& rule, std::span<const LineConfig> lines) {
    const auto pulse_json = [](Pulse pulse) { return number_json(pulse.microseconds()); };
    Json json = Json::object();
    if (const auto* fixed = std::get_if<Fixed>(&rule.source)) {
        json["fixed"] = pulse_json(fixed->pulse);
    } else if (const auto* line = std::get_if<FromLine>(&rule.source)) {
        json["line"] = lines[line->line].name;
    } else if (const auto* limits = std::get_if<Switch>(&rule.source)) {
        json["from"] = number_of(limits->channel);
        if (limits->above) {
            json["above"] = pulse_json(*limits->above);
        }
        if (limits->below) {
            json["below"] = pulse_json(*limits->below);
        }
    } else {
        const auto* from = std::get_if<FromChannel>(&rule.source);
        if (rule == ChannelRule{.output = rule.output, .source = rule.source} && from != nullptr) {
            return number_of(from->channel);
        }
        if (from != nullptr) {
            json["from"] = number_of(from->channel);
        } else {
            json["mix"] = mix_json(std::get<Mix>(rule.source));
        }
        json.update(fields_json(rule, channel_keys()));
    }
    return json;
}

}  // namespace tribus
