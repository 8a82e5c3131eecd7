#include "pipelines/rules/slew_limits.h"

#include <algorithm>

#include "core/rounding.h"

namespace tribus {

void SlewLimits::add(const ChannelMap* map) {
    const bool first = rates_.empty();
    Rates& rates = rates_.emplace_back();
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        rates[channel] = map != nullptr ? map->slew_of(channel) : std::nullopt;
        any_ = any_ || rates[channel];
        std::optional<double>& fastest = fastest_[channel];
        const bool limited = rates[channel] && (first || fastest);
        fastest = limited ? std::max(fastest, rates[channel]) : std::nullopt;
    }
}

void SlewLimits::start(const ChannelFrame& frame) {
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        const std::optional<Pulse> pulse = frame.channel(channel);
        reached_[channel] = pulse ? std::optional<double>(pulse->eighths()) : std::nullopt;
    }
}

void SlewLimits::apply(ChannelFrame& frame, std::size_t place, Duration passed) {
    limit(frame, rates_[place], passed);
}

void SlewLimits::apply_to_all(ChannelFrame& frame, Duration passed) {
    limit(frame, fastest_, passed);
}

void SlewLimits::limit(ChannelFrame& frame, const Rates& rates, Duration passed) {
    const auto nanoseconds = static_cast<double>(passed.count());
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        std::optional<double>& reached = reached_[channel];
        if (!frame.has(channel)) {
            reached.reset();
            continue;
        }
        const double wanted = frame.pulses()[channel].eighths();
        if (!reached || !rates[channel]) {
            reached = wanted;
            continue;
        }
        const double most = *rates[channel] * nanoseconds;
        *reached += std::clamp(wanted - *reached, -most, most);
        frame.set(channel, Pulse::from_eighths(nearest_whole(*reached)));
    }
}

}  // namespace tribus
