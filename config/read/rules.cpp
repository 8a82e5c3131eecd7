#include "config/read/rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "config/language/nearest.h"
#include "config/read/value.h"
#include "config/schema/notation.h"
#include "core/quotes.h"

namespace tribus {
namespace {

void check_value_rule(const RuleRef& ref, const TableContent& content, Reading reading) {
    const Location where = ref.value.where;
    const bool limited = has_value_limit(content);
    if (content.values().get_or("all_zero", false)) {
        if (content.given("channel") || limited) {
            reading.mistakes.add(
                content.where("all_zero"),
                "\"all_zero\" applies to all channels; a rule with it has no other key");
        }
        return;
    }
    if (reading.lost.affects(where)) {
        return;
    }
    if (!content.given("channel")) {
        reading.mistakes.add(where, fmt::format("{} has no \"channel\"; required, such as {}",
                                                ref.title, ref.example));
    }
    if (!limited) {
        reading.mistakes.add(where,
                             fmt::format("{} has no limit; at least one of {} is required, "
                                         "such as {}",
                                         ref.title, in_quotes_all(kValueLimits), ref.example));
    }
    check_limits(content, "below", "above", ref.otherwise, reading.mistakes);
}

}  // namespace

std::optional<ValueRule> read_value_rule(const RuleRef& ref, Reading reading) {
    const auto* table = ref.value.as<Table>();
    if (table == nullptr) {
        reading.mistakes.add(ref.value.where,
                             fmt::format("{} is {}; allowed: a table, such as {}", ref.title,
                                         describe(ref.value), ref.example));
        return std::nullopt;
    }
    const TableContent content =
        read_table({*table, ref.value.where, ref.title}, ref.keys, reading);
    check_value_rule(ref, content, reading);
    ValueRule rule;
    content.read_into(rule);
    return rule;
}

bool has_value_limit(const TableContent& content) {
    return std::ranges::any_of(kValueLimits,
                               [&](std::string_view limit) { return content.given(limit); });
}

std::optional<std::size_t> channel_of(std::string_view key) {
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (key == std::to_string(channel + 1)) {
            return channel;
        }
    }
    return std::nullopt;
}

std::string allowed_channels() {
    return fmt::format("channel numbers from 1 to {}", kChannelCount);
}

Presets default_presets() {
    Presets presets;
    presets.fill(kCentrePulse);
    presets[2] = Pulse::from_microseconds(988);
    return presets;
}

std::optional<Presets> read_presets(const Value& value, Mistakes& mistakes) {
    const auto* table = value.as<Table>();
    if (table == nullptr) {
        mistakes.add(value.where,
                     fmt::format("\"preset\" is {}; allowed: a table of pulses by channel number, "
                                 "such as {}",
                                 describe(value), kDefaultPreset));
        return std::nullopt;
    }
    Presets presets;
    presets.fill(kCentrePulse);
    if (const Entry* other = table->find(kOtherChannels)) {
        if (const auto pulse = read_pulse("preset.other", other->value, mistakes)) {
            presets.fill(Pulse::from_fractional_microseconds(*pulse));
        }
    }
    for (const Entry& entry : table->entries) {
        if (entry.key == kOtherChannels) {
            continue;
        }
        const auto channel = channel_of(entry.key);
        if (!channel) {
            const std::array allowed{kOtherChannels};
            const bool near = nearest(entry.key, allowed).has_value();
            mistakes.add(entry.where,
                         fmt::format("{} in \"preset\" is not a channel; {}: {}, and \"other\"",
                                     in_quotes(entry.key),
                                     near ? "did you mean \"other\"? Allowed" : "allowed",
                                     allowed_channels()));
        } else if (const auto pulse = read_pulse("preset." + entry.key, entry.value, mistakes)) {
            presets[*channel] = Pulse::from_fractional_microseconds(*pulse);
        }
    }
    return presets;
}

void check_limits(const TableContent& content, std::string_view lower, std::string_view upper,
                  std::string_view otherwise, Mistakes& mistakes) {
    const auto low = pulse_of(content, lower);
    const auto high = pulse_of(content, upper);
    if (low && high && *low >= *high) {
        mistakes.add(content.where(upper),
                     fmt::format("{} is {} and {} is {}, so {}; allowed: {} less than {}",
                                 in_quotes(lower), format_number(low->microseconds()),
                                 in_quotes(upper), format_number(high->microseconds()), otherwise,
                                 in_quotes(lower), in_quotes(upper)));
    }
}

std::optional<Pulse> pulse_of(const TableContent& content, std::string_view key) {
    const auto* microseconds = content.values().find_as<double>(key);
    return microseconds != nullptr
               ? std::optional(Pulse::from_fractional_microseconds(*microseconds))
               : std::nullopt;
}

}  // namespace tribus
