#include "config/read_rules.h"

#include <fmt/format.h>

#include <charconv>

#include "config/nearest.h"
#include "config/read_value.h"
#include "config/values.h"
#include "core/quotes.h"

namespace tribus {
namespace {

constexpr std::string_view kLossRuleExample = "[{ channel = 3, below = 950 }]";

std::optional<LossRule> read_loss_rule(const Value& value, Reading reading) {
    const auto* table = value.as<Table>();
    if (table == nullptr) {
        reading.mistakes.add(value.where,
                             fmt::format("a rule of \"failsafe_when\" is {}; allowed: a table, "
                                         "such as {}",
                                         describe(value), kLossRuleExample));
        return std::nullopt;
    }
    const TableContent content =
        read_table({*table, value.where, "a rule of \"failsafe_when\""}, loss_rule_keys(), reading);
    if (!content.given("below") && !content.given("above") && !reading.lost.hurts(value.where)) {
        reading.mistakes.add(value.where,
                             fmt::format("a rule of \"failsafe_when\" has no limit; at least one "
                                         "of \"below\" and \"above\" is required, such as {}",
                                         kLossRuleExample));
    }
    check_limits(content, "below", "above", "every value would be loss", reading.mistakes);
    const auto channel = content.values().get_or<std::int64_t>("channel", 1);
    return LossRule{static_cast<std::size_t>(channel - 1), pulse_of(content, "below"),
                    pulse_of(content, "above")};
}

}  // namespace

std::optional<std::size_t> channel_of(std::string_view key) {
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), number);
    if (error != std::errc{} || end != key.data() + key.size() || key.starts_with('0') ||
        number < 1 || number > kChannelCount) {
        return std::nullopt;
    }
    return number - 1;
}

std::string allowed_channels() {
    return fmt::format("channel numbers from 1 to {}", kChannelCount);
}

std::vector<LossRule> read_loss_rules(const Value& value, Reading reading) {
    std::vector<LossRule> rules;
    const auto* list = value.as<List>();
    if (list == nullptr) {
        reading.mistakes.add(value.where, fmt::format("\"failsafe_when\" is {}; allowed: a list of "
                                                      "rules, such as {}",
                                                      describe(value), kLossRuleExample));
        return rules;
    }
    for (const Value& item : list->items) {
        if (const auto rule = read_loss_rule(item, reading)) {
            rules.push_back(*rule);
        }
    }
    return rules;
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
        const auto pulse = read_pulse("preset.other", other->value, mistakes);
        presets.fill(Pulse::from_fractional_microseconds(pulse.value_or(0)));
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
