#include "app/learn/loss_rules.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "config/schema/notation.h"

namespace tribus {
namespace {

/// Least distance of a lost value from the range of flown values.
constexpr std::int32_t kLeastMarginEighths = 12 * Pulse::kEighthsPerMicrosecond;
/// Least distance of a value between two switch positions from either of them.
constexpr std::int32_t kLeastGapEighths = 60 * Pulse::kEighthsPerMicrosecond;
/// A channel with this much travel was moved by a person.
constexpr std::int32_t kMovedEighths = 200 * Pulse::kEighthsPerMicrosecond;
constexpr Pulse kLeast = Pulse::from_eighths(INT16_MIN);
constexpr Pulse kGreatest = Pulse::from_eighths(INT16_MAX);

/// In whole microseconds, as people write them.
Pulse halfway(Pulse a, Pulse b) {
    return Pulse::from_microseconds((a.whole_microseconds() + b.whole_microseconds()) / 2);
}

/// A rule that matches a lost link, and its distance from all flown values.
struct Candidate {
    ValueRule rule;
    std::int32_t margin_eighths = 0;
    /// The channel was moved, so its range is known.
    bool moved = false;

    bool better_than(const Candidate& other) const {
        return std::pair(moved, margin_eighths) > std::pair(other.moved, other.margin_eighths);
    }
};

Candidate beyond_range(std::size_t channel, const PulseRange& flown, const PulseRange& lost) {
    const std::int32_t under = flown.low.eighths() - lost.high.eighths();
    const std::int32_t over = lost.low.eighths() - flown.high.eighths();
    const bool moved = flown.high.eighths() - flown.low.eighths() >= kMovedEighths;
    if (under >= over) {
        return {{.channel = channel, .below = halfway(flown.low, lost.high)}, under, moved};
    }
    return {{.channel = channel, .above = halfway(flown.high, lost.low)}, over, moved};
}

Candidate within_gap(std::size_t channel, StudiedFrames flown, const PulseRange& lost) {
    Pulse under = kLeast;
    Pulse over = kGreatest;
    for (const StudiedFrame& studied : flown) {
        const auto pulse = studied.frame.channel(channel);
        if (!pulse) {
            continue;
        }
        if (lost.contains(*pulse)) {
            return {};
        }
        if (*pulse < lost.low) {
            under = std::max(under, *pulse);
        } else {
            over = std::min(over, *pulse);
        }
    }
    const PulseRange gap{halfway(under, lost.low), halfway(over, lost.high)};
    const std::int32_t margin =
        std::min(lost.low.eighths() - under.eighths(), over.eighths() - lost.high.eighths());
    return {{.channel = channel, .between = gap}, margin};
}

}  // namespace

std::optional<PulseRange> pulses_of(StudiedFrames frames, std::size_t channel) {
    PulseRange range{kGreatest, kLeast};
    for (const StudiedFrame& studied : frames) {
        if (const auto pulse = studied.frame.channel(channel)) {
            range = {std::min(range.low, *pulse), std::max(range.high, *pulse)};
        }
    }
    return range.low <= range.high ? std::optional(range) : std::nullopt;
}

std::optional<ValueRule> rule_for_loss(StudiedFrames flown, StudiedFrames lost) {
    Candidate best_beyond;
    Candidate best_gap;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        const auto live = pulses_of(flown, channel);
        const auto dead = pulses_of(lost, channel);
        if (!live || !dead) {
            continue;
        }
        const Candidate beyond = beyond_range(channel, *live, *dead);
        const Candidate gap = within_gap(channel, flown, *dead);
        if (beyond.margin_eighths >= kLeastMarginEighths && beyond.better_than(best_beyond)) {
            best_beyond = beyond;
        }
        best_gap = gap.margin_eighths > best_gap.margin_eighths ? gap : best_gap;
    }
    if (best_beyond.margin_eighths > 0) {
        return best_beyond.rule;
    }
    return best_gap.margin_eighths >= kLeastGapEighths ? std::optional(best_gap.rule)
                                                       : std::nullopt;
}

bool all_at(const ChannelFrame& frame, Pulse zero) {
    constexpr std::size_t kNumberedChannels = 16;
    for (std::size_t channel = 0; channel < kNumberedChannels; ++channel) {
        if (frame.channel_or(channel, zero) != zero) {
            return false;
        }
    }
    return frame.has(0);
}

std::string rule_text(const ValueRule& rule) {
    if (rule.all_zero) {
        return "all_zero = true";
    }
    const auto number = [](Pulse pulse) { return format_number(pulse.microseconds()); };
    const std::string channel = fmt::format("channel = {}", rule.channel + 1);
    if (rule.below) {
        return fmt::format("{}, below = {}", channel, number(*rule.below));
    }
    if (rule.above) {
        return fmt::format("{}, above = {}", channel, number(*rule.above));
    }
    return fmt::format("{}, between = [{}, {}]", channel, number(rule.between->low),
                       number(rule.between->high));
}

}  // namespace tribus
