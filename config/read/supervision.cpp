#include "config/read/supervision.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <string_view>
#include <vector>

#include "config/read/doubts.h"
#include "config/read/rules.h"
#include "config/schema/notation.h"
#include "core/quotes.h"

namespace tribus {
namespace {

constexpr std::string_view kLossRuleExample = "[{ channel = 3, below = 950 }]";
constexpr std::array<std::string_view, 4> kFlagKeys{"failsafe_flag", "frame_lost_flag",
                                                    "frame_lost_run", "frame_lost_ratio"};

/// `possible`: the channels that the protocol can have.
void doubt_loss_rule(const ValueRule& rule, std::uint32_t possible, Location where,
                     Mistakes& warnings) {
    constexpr std::string_view kTitle = "this rule of \"failsafe_when\"";
    if (!rule.all_zero && ((possible >> rule.channel) & 1U) == 0) {
        warnings.add(where, fmt::format("{}: the input has no channel {}, so the rule never says "
                                        "anything; give a channel that it has",
                                        kTitle, rule.channel + 1));
        return;
    }
    doubt_rule(rule, RuleUse::loss, kTitle, kWireReach, where, warnings);
}

std::vector<ValueRule> read_loss_rules(const Value& value, const Protocol* protocol,
                                       std::uint32_t possible, Reading reading) {
    std::vector<ValueRule> rules;
    const auto* list = value.as<List>();
    if (list == nullptr) {
        reading.mistakes.add(value.where, fmt::format("\"failsafe_when\" is {}; allowed: a list of "
                                                      "rules, such as {}",
                                                      describe(value), kLossRuleExample));
        return rules;
    }
    for (const Value& item : list->items) {
        const auto rule = read_value_rule({item, "a rule of \"failsafe_when\"", kLossRuleExample,
                                           "every value would mean loss", loss_rule_keys()},
                                          reading);
        if (!rule) {
            continue;
        }
        if (rule->all_zero && protocol != nullptr && protocol->raw_zero == nullptr) {
            reading.mistakes.add(item.where,
                                 fmt::format("\"all_zero\" has no effect: {} has no zero that "
                                             "means \"no value\"; allowed with \"sbus\"",
                                             in_quotes(protocol->name)));
        }
        doubt_loss_rule(*rule, possible, item.where, reading.warnings);
        rules.push_back(*rule);
    }
    return rules;
}

/// Three of the periods that the settings give, if any, so that one lost message is no loss.
Duration default_timeout(const Protocol& protocol, const SettingValues& settings) {
    constexpr Duration kUsual = SupervisionSettings{}.timeout;
    constexpr Duration kMost = std::chrono::seconds(10);
    const auto period =
        protocol.own_period == nullptr ? std::nullopt : protocol.own_period(settings);
    return period ? std::clamp(3 * *period, kUsual, kMost)
                  : protocol.default_timeout.value_or(kUsual);
}

/// Reports checks that do not apply to this protocol.
void check_use(const TableContent& content, const Protocol& protocol, const SettingValues& settings,
               Mistakes& mistakes) {
    for (const std::string_view key : kFlagKeys) {
        if (content.given(key) && !has_flags(protocol, settings)) {
            mistakes.add(
                content.find(key)->where,
                fmt::format(
                    "{} has no effect: {} cannot mark a frame as lost; use \"failsafe_when\" or "
                    "\"frozen\" to detect what its receivers do instead",
                    in_quotes(key), in_quotes(protocol.name)));
        }
    }
    if (content.given("zero_guard") && protocol.raw_zero == nullptr) {
        mistakes.add(content.find("zero_guard")->where,
                     fmt::format("\"zero_guard\" has no effect: {} has no zero that means \"no "
                                 "value\"; allowed with \"sbus\"",
                                 in_quotes(protocol.name)));
    }
}

}  // namespace

bool is_about_flags(std::string_view key) {
    return std::ranges::find(kFlagKeys, key) != kFlagKeys.end();
}

bool has_flags(const Protocol& protocol, const SettingValues& settings) {
    return protocol.shape == WireShape::can_frames || protocol.signals_failsafe(settings);
}

SupervisionSettings read_supervision(const TableContent& content, const Protocol* protocol,
                                     const SettingValues& settings, bool settings_sound,
                                     Reading reading) {
    SupervisionSettings supervision;
    content.read_into(supervision);
    if (settings_sound && !content.given("timeout")) {
        supervision.timeout = default_timeout(*protocol, settings);
    }
    supervision.fewer_channels_after = supervision.timeout;
    if (const Entry* rules = content.find("failsafe_when")) {
        const bool known = settings_sound && protocol->possible_channels != nullptr;
        supervision.failsafe_when =
            read_loss_rules(rules->value, protocol,
                            known ? protocol->possible_channels(settings) : kAllChannels, reading);
    }
    doubt_supervision(supervision, content.where("frozen"), content.where("plausible"),
                      reading.warnings);
    if (settings_sound) {
        check_use(content, *protocol, settings, reading.mistakes);
        if (protocol->optional_channels != nullptr) {
            supervision.optional_channels = protocol->optional_channels(settings);
        }
        if (protocol->raw_zero != nullptr) {
            supervision.raw_zero = protocol->raw_zero(settings);
        }
    }
    return supervision;
}

}  // namespace tribus
