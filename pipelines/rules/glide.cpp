#include "pipelines/rules/glide.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/rounding.h"

namespace tribus {

void Glide::set_rate(double us_per_second) {
    constexpr double kNanosecondsPerSecond = 1e9;
    eighths_per_nanosecond_ = us_per_second * Pulse::kEighthsPerMicrosecond / kNanosecondsPerSecond;
}

void Glide::start(const ChannelFrame& from, double us_per_second, Instant now) {
    set_rate(us_per_second);
    latest_at_ = now;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        under_way_[channel] = from.has(channel);
        reached_eighths_[channel] = from.pulses()[channel].eighths();
    }
}

void Glide::start_anew(const ChannelFrame& from, double us_per_second, Instant now) {
    const bool on_its_way = under_way_.any();
    const double before = eighths_per_nanosecond_;
    start(from, us_per_second, now);
    eighths_per_nanosecond_ =
        on_its_way ? std::min(before, eighths_per_nanosecond_) : eighths_per_nanosecond_;
}

void Glide::move(ChannelFrame& frame, Instant now) {
    const double most = eighths_per_nanosecond_ * static_cast<double>((now - latest_at_).count());
    latest_at_ = now;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (!under_way_[channel]) {
            continue;
        }
        const double left = frame.pulses()[channel].eighths() - reached_eighths_[channel];
        if (!frame.has(channel) || std::abs(left) <= most) {
            under_way_[channel] = false;
            continue;
        }
        reached_eighths_[channel] += std::copysign(most, left);
        frame.set(channel, Pulse::from_eighths(nearest_whole(reached_eighths_[channel])));
    }
}

void Glide::show(ChannelFrame& frame) const {
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (under_way_[channel] && frame.has(channel)) {
            frame.set(channel, Pulse::from_eighths(nearest_whole(reached_eighths_[channel])));
        }
    }
}

}  // namespace tribus
