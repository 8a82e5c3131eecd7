#include "pipelines/rules/channel_map.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/rounding.h"

namespace tribus {
namespace {

constexpr Pulse kLeastPulse = Pulse::from_eighths(INT16_MIN);
constexpr Pulse kGreatestPulse = Pulse::from_eighths(INT16_MAX);
constexpr double kFullTravelEighths = 500.0 * Pulse::kEighthsPerMicrosecond;

double deviation(WidePulse pulse) {
    return pulse - kCentrePulse.eighths();
}
WidePulse from_deviation(double eighths) {
    return static_cast<WidePulse>(kCentrePulse.eighths() + nearest_whole(eighths));
}
/// Zero if the frame is older than what was computed last, as after a reload.
double nanoseconds_between(Instant since, Instant now) {
    return static_cast<double>(std::max(now - since, Duration::zero()).count());
}

/// Reads the source of one output channel from an input frame.
struct SourceReader {
    const ChannelFrame& input;
    LineLevels lines;

    std::optional<WidePulse> operator()(const FromChannel& from) const {
        const std::optional<Pulse> pulse = input.channel(from.channel);
        return pulse ? std::optional(pulse->eighths()) : std::nullopt;
    }
    std::optional<WidePulse> operator()(const Mix& mix) const {
        double sum = 0;
        for (const MixTerm& term : mix.terms) {
            if (!input.has(term.channel)) {
                return std::nullopt;
            }
            sum += term.weight * deviation(input.channel_or(term.channel, kCentrePulse).eighths());
        }
        return from_deviation(sum);
    }
    std::optional<WidePulse> operator()(const Fixed& fixed) const { return fixed.pulse.eighths(); }
    std::optional<WidePulse> operator()(const Switch& lever) const {
        const std::optional<Pulse> pulse = input.channel(lever.channel);
        if (!pulse) {
            return std::nullopt;
        }
        const bool on =
            (lever.above && *pulse > *lever.above) || (lever.below && *pulse < *lever.below);
        return position(on);
    }
    std::optional<WidePulse> operator()(const FromLine& from) const {
        const std::optional<bool> level = lines.of(from.line);
        return level ? std::optional(position(*level)) : std::nullopt;
    }

    static WidePulse position(bool on) { return (on ? kSwitchOnPulse : kSwitchOffPulse).eighths(); }
};

std::vector<Filter> filters_of(const ChannelRule& rule) {
    std::vector<Filter> filters;
    if (rule.deadband != Pulse{}) {
        filters.emplace_back(DeadbandFilter{rule.deadband});
    }
    if (rule.expo != 0) {
        filters.emplace_back(ExpoFilter{rule.expo});
    }
    if (rule.reverse) {
        filters.emplace_back(ReverseFilter{});
    }
    if (rule.trim != Pulse{}) {
        filters.emplace_back(TrimFilter{rule.trim});
    }
    if (rule.slew_us_per_second) {
        constexpr double kNanosecondsPerSecond = 1e9;
        filters.emplace_back(SlewFilter{.eighths_per_nanosecond = *rule.slew_us_per_second *
                                                                  Pulse::kEighthsPerMicrosecond /
                                                                  kNanosecondsPerSecond});
    }
    if (rule.min || rule.max) {
        filters.emplace_back(
            LimitFilter{rule.min.value_or(kLeastPulse), rule.max.value_or(kGreatestPulse)});
    }
    return filters;
}

}  // namespace

WidePulse DeadbandFilter::apply(WidePulse pulse, Instant /*now*/) {
    const double from_centre = deviation(pulse);
    const double size = std::abs(from_centre);
    const double edge = width.eighths();
    if (size <= edge) {
        return kCentrePulse.eighths();
    }
    if (size >= kFullTravelEighths) {
        return pulse;
    }
    const double stretched = (size - edge) * kFullTravelEighths / (kFullTravelEighths - edge);
    return from_deviation(std::copysign(stretched, from_centre));
}

WidePulse ExpoFilter::apply(WidePulse pulse, Instant /*now*/) {
    const double travel = deviation(pulse) / kFullTravelEighths;
    if (std::abs(travel) >= 1) {
        return pulse;
    }
    return from_deviation(((1 - share) * travel + share * travel * travel * travel) *
                          kFullTravelEighths);
}

WidePulse ReverseFilter::apply(WidePulse pulse, Instant /*now*/) {
    return 2 * kCentrePulse.eighths() - pulse;
}

WidePulse TrimFilter::apply(WidePulse pulse, Instant /*now*/) {
    return pulse + offset.eighths();
}

WidePulse SlewFilter::apply(WidePulse pulse, Instant now) {
    const double wanted = Pulse::from_eighths(pulse).eighths();
    if (!started) {
        latest_eighths = wanted;
    } else {
        const double most = eighths_per_nanosecond * nanoseconds_between(latest_at, now);
        latest_eighths += std::clamp(wanted - latest_eighths, -most, most);
    }
    started = true;
    latest_at = std::max(latest_at, now);
    return static_cast<WidePulse>(nearest_whole(latest_eighths));
}

WidePulse LimitFilter::apply(WidePulse pulse, Instant /*now*/) {
    return std::clamp(pulse, min.eighths(), max.eighths());
}

StraightLanes::StraightLanes() {
    std::iota(input_.begin(), input_.end(), std::uint8_t{0});
}

bool StraightLanes::take(const ChannelRule& rule) {
    const auto* from = std::get_if<FromChannel>(&rule.source);
    if (from == nullptr || rule.deadband != Pulse{} || rule.expo != 0 || rule.slew_us_per_second) {
        return false;
    }
    constexpr int kTwiceCentre = 2 * kCentrePulse.eighths();
    const int min = rule.min.value_or(kLeastPulse).eighths();
    const int max = rule.max.value_or(kGreatestPulse).eighths();
    const int trim = rule.trim.eighths();
    const int mirrored = kTwiceCentre + trim;
    const int least = std::max(rule.reverse ? mirrored - max : min - trim, INT16_MIN);
    const int most = std::min(rule.reverse ? mirrored - min : max - trim, INT16_MAX);
    if (least > most || least > INT16_MAX || most < INT16_MIN) {
        return false;
    }
    unchanged_ = false;
    in_place_ = in_place_ && from->channel == rule.output;
    input_[rule.output] = static_cast<std::uint8_t>(from->channel);
    least_.set(rule.output, static_cast<std::int16_t>(least));
    most_.set(rule.output, static_cast<std::int16_t>(most));
    turned_.set(rule.output, rule.reverse ? -1 : 0);
    // The negative of a number is 1 more than the number with all bits turned.
    offset_.set(rule.output, static_cast<std::int16_t>(rule.reverse ? mirrored + 1 : trim));
    return true;
}

/// Limits, turns and moves the values of a group.
inline void StraightLanes::change_group(std::size_t group, const ChannelFrame& from,
                                        ChannelFrame& to) const {
    ChannelGroup values = group_of(from, group);
    const std::int16_t* const least = least_.group(group);
    const std::int16_t* const most = most_.group(group);
    const std::int16_t* const turned = turned_.group(group);
    const std::int16_t* const offset = offset_.group(group);
    const std::int16_t* const present = present_out_.group(group);
    // std::clamp returns references, which keeps the compiler from using vector instructions.
    for (std::size_t lane = 0; lane < kGroupChannels; ++lane) {
        std::int16_t limited = values[lane];
        limited = limited < least[lane] ? least[lane] : limited;
        limited = limited > most[lane] ? most[lane] : limited;
        const auto moved = static_cast<std::int16_t>((limited ^ turned[lane]) + offset[lane]);
        values[lane] = static_cast<std::int16_t>(moved & present[lane]);
    }
    set_group(to, group, values);
}

/// Without a loop, so that the compiler knows where each group is.
inline void StraightLanes::change_all(const ChannelFrame& from, ChannelFrame& to) const {
    static_assert(kGroupBegins.size() == 3);
    change_group(0, from, to);
    change_group(1, from, to);
    change_group(2, from, to);
}

[[gnu::noinline]] void StraightLanes::change(const ChannelFrame& input, ChannelFrame& output) {
    if (input.absent() != absent_in_) {
        look_who_is_absent(input.absent());
    }
    output.mark_only_absent(absent_out_);
    if (in_place_) {
        change_all(input, output);
    } else {
        change_gathered(input, output);
    }
}

/// Not inline: nearly all maps read in place.
[[gnu::noinline]] void StraightLanes::change_gathered(const ChannelFrame& input,
                                                      ChannelFrame& output) const {
    ChannelFrame values;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        values.pulses()[channel] = input.pulses()[input_[channel]];
    }
    change_all(values, output);
}

/// A receiver with 14 channels, for example, leaves the others absent.
[[gnu::noinline]] void StraightLanes::look_who_is_absent(std::uint32_t absent) {
    absent_in_ = absent;
    absent_out_ = 0;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        absent_out_ |= (absent >> input_[channel] & 1U) << channel;
    }
    present_out_ = present_channels(absent_out_);
}

ChannelMap::ChannelMap(std::span<const ChannelRule> rules) {
    for (const ChannelRule& rule : rules) {
        if (!straight_lanes_.take(rule)) {
            lanes_.push_back({rule.output, rule.source, filters_of(rule)});
        }
    }
}

[[gnu::noinline]] void ChannelMap::apply_lanes(const ChannelFrame& input, ChannelFrame& output,
                                               Instant now) {
    for (Lane& lane : lanes_) {
        std::optional<WidePulse> pulse = std::visit(SourceReader{input, lines_}, lane.source);
        if (pulse) {
            for (Filter& filter : lane.filters) {
                pulse = std::visit([&](auto& step) { return step.apply(*pulse, now); }, filter);
            }
        }
        output.set(lane.output, pulse ? std::optional(Pulse::from_eighths(*pulse)) : std::nullopt);
    }
}

ChannelFrame ChannelMap::aim(const ChannelFrame& input) const {
    ChannelFrame output = input;
    StraightLanes straight = straight_lanes_;
    straight.apply(input, output);
    for (const Lane& lane : lanes_) {
        std::optional<WidePulse> pulse = std::visit(SourceReader{input, lines_}, lane.source);
        for (const Filter& filter : lane.filters) {
            if (pulse && !std::holds_alternative<SlewFilter>(filter)) {
                pulse = std::visit([&](auto step) { return step.apply(*pulse, {}); }, filter);
            }
        }
        output.set(lane.output, pulse ? std::optional(Pulse::from_eighths(*pulse)) : std::nullopt);
    }
    return output;
}

template <class Action>
void ChannelMap::for_each_slew(Action action) {
    for (Lane& lane : lanes_) {
        for (Filter& filter : lane.filters) {
            if (auto* slew = std::get_if<SlewFilter>(&filter)) {
                action(lane.output, *slew);
            }
        }
    }
}

void ChannelMap::restart_lanes(const ChannelFrame& frame, Instant now, std::uint32_t channels) {
    const std::uint32_t restarted = channels & ~frame.absent();
    for_each_slew([&](std::size_t channel, SlewFilter& slew) {
        if ((restarted >> channel & 1U) != 0) {
            slew.started = true;
            slew.latest_eighths = frame.pulses()[channel].eighths();
            slew.latest_at = now;
        }
    });
}

void ChannelMap::rest(Instant until) {
    for_each_slew([&](std::size_t /*channel*/, SlewFilter& slew) { slew.rest(until); });
}

std::optional<double> ChannelMap::slew_of(std::size_t channel) const {
    for (const Lane& lane : lanes_) {
        for (const Filter& filter : lane.filters) {
            const auto* slew = std::get_if<SlewFilter>(&filter);
            if (slew != nullptr && lane.output == channel) {
                return slew->eighths_per_nanosecond;
            }
        }
    }
    return std::nullopt;
}

bool ChannelMap::has_slews() const {
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (slew_of(channel)) {
            return true;
        }
    }
    return false;
}

}  // namespace tribus
