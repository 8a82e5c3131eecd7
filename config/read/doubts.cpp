#include "config/read/doubts.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <variant>

#include <fmt/format.h>

#include "config/schema/notation.h"
#include "core/quotes.h"

namespace tribus {
namespace {

constexpr std::string_view kEveryStick = "every position of a stick from 1000 to 2000 us";

/// The share of the values of `reach`, in whole microseconds, that fulfil the rule. Protocols round
/// the ends of the reach by less than one.
enum class Share : std::uint8_t { none, some, all };

Share fulfilled(const ValueRule& rule, ChannelReach reach) {
    bool any = false;
    bool all = true;
    for (auto us = std::llround(reach.low) - 1; us <= std::llround(reach.high) + 1; ++us) {
        const bool holds = rule.matches(Pulse::from_microseconds(us));
        any = any || holds;
        all = all && holds;
    }
    return all ? Share::all : any ? Share::some : Share::none;
}

std::string_view if_always(RuleUse use) {
    switch (use) {
        case RuleUse::loss:
            return "means a loss, so the link would never count";
        case RuleUse::release:
            return "releases control, so it holds nothing back";
        case RuleUse::on:
            break;
    }
    return "switches it on, so it would always be on";
}

ChannelReach raw_reach(const ChannelRule& rule) {
    if (const auto* fixed = std::get_if<Fixed>(&rule.source)) {
        return {fixed->pulse.microseconds(), fixed->pulse.microseconds()};
    }
    if (std::holds_alternative<Switch>(rule.source) ||
        std::holds_alternative<FromLine>(rule.source)) {
        return kFullTravel;
    }
    if (std::holds_alternative<Mix>(rule.source)) {
        return kWireReach;
    }
    const double trim = rule.trim.microseconds();
    return {kStickReach.low + std::min(trim, 0.0), kStickReach.high + std::max(trim, 0.0)};
}

}  // namespace

ChannelReach reach_of(std::size_t channel, const std::vector<ChannelRule>& rules) {
    const auto rule = std::ranges::find(rules, channel, &ChannelRule::output);
    if (rule == rules.end()) {
        return kStickReach;
    }
    ChannelReach reach = raw_reach(*rule);
    const double low = rule->min ? rule->min->microseconds() : reach.low;
    const double high = rule->max ? rule->max->microseconds() : reach.high;
    return {std::clamp(reach.low, low, std::max(low, high)),
            std::clamp(reach.high, std::min(low, high), high)};
}

void doubt_rule(const ValueRule& rule, RuleUse use, std::string_view title, ChannelReach reach,
                Location where, Mistakes& warnings) {
    if (rule.all_zero) {
        return;
    }
    const bool always = fulfilled(rule, kFullTravel) == Share::all;
    if (always && use != RuleUse::release) {
        warnings.add(where, fmt::format("{}: {} {}; give a narrower range", title, kEveryStick,
                                        if_always(use)));
        return;
    }
    const Share share = fulfilled(rule, reach);
    if (share == Share::all) {
        warnings.add(where, fmt::format("{}: every value that the channel can have {}; leave it "
                                        "out, or give a narrower range",
                                        title, if_always(use)));
    } else if (share == Share::none) {
        warnings.add(
            where,
            fmt::format(
                "{}: the channel gets no such value, since it goes from {} to {} us{}, so {}",
                title, format_number(reach.low), format_number(reach.high),
                reach.low == kStickReach.low || reach.high == kStickReach.high
                    ? " with the usual travel of a stick"
                    : "",
                use == RuleUse::release ? "control would never be given" : "it would never be on"));
    }
}

void doubt_slew(std::optional<double> us_per_second, std::string_view key, Location where,
                Mistakes& warnings) {
    constexpr double kTravel = 1000;
    constexpr std::int64_t kMostSeconds = 60;
    if (us_per_second && std::lround(kTravel / *us_per_second) > kMostSeconds) {
        warnings.add(where, fmt::format("{} is {}, so the way from 1000 to 2000 us takes {} "
                                        "seconds; usual are \"500us/s\" and more",
                                        in_quotes(key), in_quotes(format_slew(*us_per_second)),
                                        std::lround(kTravel / *us_per_second)));
    }
}

void doubt_supervision(const SupervisionSettings& supervision, Location where_frozen,
                       Location where_plausible, Mistakes& warnings) {
    if (supervision.frozen > Duration::zero() && supervision.frozen < supervision.timeout) {
        warnings.add(
            where_frozen,
            fmt::format("\"frozen\" is {}, shorter than the timeout, {}: a stick that lies still "
                        "for a few frames would be a loss; usual are \"2s\" and more",
                        in_quotes(format_duration(supervision.frozen)),
                        in_quotes(format_duration(supervision.timeout))));
    }
    const auto& range = supervision.plausible;
    if (range && (range->low.microseconds() > kFullTravel.low ||
                  range->high.microseconds() < kFullTravel.high)) {
        warnings.add(
            where_plausible,
            fmt::format("\"plausible\" is [{}, {}]: a stick at full travel, 1000 or 2000 us, is "
                        "outside, and its frames would not count; usual are [800, 2200]",
                        format_number(range->low.microseconds()),
                        format_number(range->high.microseconds())));
    }
}

}  // namespace tribus
