#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "config/language/nearest.h"
#include "config/language/numbers.h"
#include "config/read/doubts.h"
#include "config/read/rules.h"
#include "config/read/value.h"
#include "config/schema/notation.h"
#include "core/quotes.h"

namespace tribus {
namespace {

constexpr std::array<std::string_view, 2> kSwitchLimits{"above", "below"};

Mix read_mix(const Value& value, Mistakes& mistakes) {
    Mix mix;
    const auto* table = value.as<Table>();
    if (table == nullptr || table->entries.empty()) {
        mistakes.add(value.where, fmt::format("\"mix\" is {}; allowed: a table of weights by "
                                              "channel number, such as {{ 1 = 0.5, 2 = -0.5 }}",
                                              table == nullptr ? describe(value) : "empty"));
        return mix;
    }
    for (const Entry& entry : table->entries) {
        const auto channel = channel_of(entry.key);
        const auto weight = number_within(entry.value, -kMostWeight, kMostWeight);
        if (!channel) {
            mistakes.add(entry.where, fmt::format("{} in \"mix\" is not a channel; allowed: {}",
                                                  in_quotes(entry.key), allowed_channels()));
        } else if (!weight) {
            mistakes.add(entry.value.where,
                         fmt::format("the weight of channel {} is {}; allowed: a number from {} "
                                     "to {}{}",
                                     entry.key, describe(entry.value), format_number(-kMostWeight),
                                     format_number(kMostWeight), without_quotes_hint(entry.value)));
        } else {
            mix.terms.push_back({*channel, *weight});
        }
    }
    return mix;
}

std::string given_sources(const TableContent& content) {
    std::vector<std::string_view> given;
    for (const std::string_view source : channel_source_names()) {
        if (content.given(source)) {
            given.push_back(source);
        }
    }
    return given.empty() ? "no source" : in_quotes_all(given);
}

/// Checks that there is one source, that a switch has `from`, and that a switch, a line and a fixed
/// pulse have no shaping keys.
void check_combination(const TableContent& content, const TableRef& ref, Mistakes& mistakes) {
    const auto sources = channel_source_names();
    const auto count = std::count_if(sources.begin(), sources.end(),
                                     [&](std::string_view key) { return content.given(key); });
    if (count != 1) {
        mistakes.add(ref.where, fmt::format("{} has {}; exactly one of {} is required", ref.title,
                                            given_sources(content), in_quotes_all(sources)));
        return;
    }
    std::string_view shapeless = content.given("fixed")  ? "fixed"
                                 : content.given("line") ? "line"
                                                         : "";
    for (const std::string_view limit : kSwitchLimits) {
        if (content.given(limit) && !content.given("from")) {
            mistakes.add(
                content.find(limit)->where,
                fmt::format(
                    "{} makes a switch from one input channel; it is only allowed with \"from\"",
                    in_quotes(limit)));
        } else if (content.given(limit)) {
            shapeless = limit;
        }
    }
    for (const std::string_view shape : shaping_key_names()) {
        if (!shapeless.empty() && content.given(shape)) {
            mistakes.add(content.find(shape)->where,
                         fmt::format("{} has no effect together with {}; leave one of them out",
                                     in_quotes(shape), in_quotes(shapeless)));
        }
    }
    check_limits(content, "min", "max", "no value would be allowed", mistakes);
    check_limits(content, "below", "above", "the switch would always be on", mistakes);
}

/// The button with that name, or the nearest name.
FromLine read_line_name(const TableContent& content, Draft* draft, Reading reading) {
    const auto* name = content.values().find_as<std::string>("line");
    if (draft == nullptr) {
        reading.mistakes.add(content.find("line")->where,
                             "\"line\" makes a channel of an output; it is only allowed in "
                             "[pipeline.NAME.channels]");
        return {};
    }
    if (name == nullptr) {
        draft->channels_uncertain = true;
        return {};
    }
    std::vector<std::string_view> buttons;
    for (const LineDraft& line : draft->lines) {
        if (line.config.task.role == LineRole::button || !line.role_sound) {
            buttons.emplace_back(line.config.name);
        }
    }
    const bool known = std::ranges::find(buttons, *name) != buttons.end();
    const auto meant = known ? std::optional<std::string_view>(*name) : nearest(*name, buttons);
    draft->channels_uncertain = draft->channels_uncertain || !meant;
    if (!known && draft->line_names_known && !reading.lost.mentions(*name)) {
        reading.mistakes.add(content.where("line"),
                             buttons.empty()
                                 ? fmt::format("no line with role \"button\" is named {}; add a "
                                               "[gpio.{}] with role = \"button\"",
                                               in_quotes(*name), *name)
                                 : fmt::format("no line with role \"button\" is named {}; {}",
                                               in_quotes(*name), suggestion(*name, buttons)));
    }
    return meant ? FromLine{*index_of(draft->lines, *meant)} : FromLine{};
}

ChannelSource read_source(const TableContent& content, Draft* draft, Reading reading) {
    if (const Entry* mix = content.find("mix")) {
        return read_mix(mix->value, reading.mistakes);
    }
    if (content.given("line")) {
        return read_line_name(content, draft, reading);
    }
    if (content.given("fixed")) {
        return Fixed{pulse_of(content, "fixed").value_or(kCentrePulse)};
    }
    const auto* from = content.values().find_as<std::int64_t>("from");
    if (from == nullptr) {
        return FromChannel{};
    }
    const auto channel = static_cast<std::size_t>(*from - 1);
    if (content.given("above") || content.given("below")) {
        return Switch{channel, pulse_of(content, "above"), pulse_of(content, "below")};
    }
    return FromChannel{channel};
}

ChannelRule read_rule(std::size_t output, const TableRef& ref, Draft* draft, Reading reading) {
    const TableContent content = read_table(ref, channel_keys(), reading);
    check_combination(content, ref, reading.mistakes);
    ChannelRule rule;
    content.read_into(rule);
    rule.output = output;
    rule.source = read_source(content, draft, reading);
    doubt_slew(rule.slew_us_per_second, "slew", content.where("slew"), reading.warnings);
    if (const auto* on = std::get_if<Switch>(&rule.source)) {
        doubt_rule({.channel = on->channel, .below = on->below, .above = on->above}, RuleUse::on,
                   "this switch", kStickReach, ref.where, reading.warnings);
    }
    return rule;
}

std::optional<ChannelRule> read_channel(const Entry& entry, Draft* draft, Reading reading) {
    const auto output = channel_of(entry.key);
    if (!output) {
        reading.mistakes.add(entry.where, fmt::format("{} is not an output channel; allowed: {}",
                                                      in_quotes(entry.key), allowed_channels()));
        return std::nullopt;
    }
    if (const auto* table = entry.value.as<Table>()) {
        return read_rule(*output, {*table, entry.value.where, "channel " + entry.key}, draft,
                         reading);
    }
    const auto* number = entry.value.as<std::int64_t>();
    if (number != nullptr && *number >= 1 && *number <= std::int64_t{kChannelCount}) {
        ChannelRule rule;
        rule.output = *output;
        rule.source = FromChannel{static_cast<std::size_t>(*number - 1)};
        return rule;
    }
    reading.mistakes.add(entry.value.where,
                         fmt::format("channel {} is {}; allowed: the number of an input channel "
                                     "from 1 to {}{}, or a table such as {{ from = 1, reverse = "
                                     "true }}",
                                     entry.key, describe(entry.value), kChannelCount,
                                     without_quotes_hint(entry.value)));
    return std::nullopt;
}

}  // namespace

PlacedRules read_channels(const Value& value, const std::string& title, Draft* draft,
                          Reading reading) {
    std::vector<std::pair<ChannelRule, Location>> rules;
    const auto* table = value.as<Table>();
    const auto lose_one = [draft] {
        if (draft != nullptr) {
            draft->channels_uncertain = true;
        }
    };
    if (table == nullptr) {
        lose_one();
        reading.mistakes.add(
            value.where,
            fmt::format("{} is {}; allowed: a table, such as {{ 1 = 2 }}", title, describe(value)));
        return {};
    }
    for (const Entry& entry : table->entries) {
        if (auto rule = read_channel(entry, draft, reading)) {
            rules.emplace_back(std::move(*rule), entry.value.where);
        } else {
            lose_one();
        }
    }
    std::ranges::sort(rules, {}, [](const auto& placed) { return placed.first.output; });
    PlacedRules sorted;
    // No room for more: the daemon keeps them as long as it runs.
    sorted.rules.reserve(rules.size());
    sorted.where.reserve(rules.size());
    for (auto& [rule, where] : rules) {
        sorted.rules.push_back(std::move(rule));
        sorted.where.push_back(where);
    }
    return sorted;
}

}  // namespace tribus
