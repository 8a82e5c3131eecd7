#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <limits>

#include "core/rounding.h"

namespace tribus {

/// A pulse width in eighths of a microsecond.
///
/// One SBUS step (Betaflight's scale) is 5 eighths and one i.Bus microsecond is 8, so both decode
/// without rounding (docs/protocols/sbus.md, "Scales"). Range -4096 to 4095.875 us. Every function
/// that makes a pulse saturates; none wraps. Pure and reentrant.
class Pulse {
  public:
    static constexpr int kEighthsPerMicrosecond = 8;

    constexpr Pulse() = default;

    static constexpr Pulse from_eighths(std::int64_t eighths) {
        using Limits = std::numeric_limits<std::int16_t>;
        Pulse pulse;
        pulse.eighths_ = static_cast<std::int16_t>(
            std::clamp<std::int64_t>(eighths, Limits::min(), Limits::max()));
        return pulse;
    }

    static constexpr Pulse from_microseconds(std::int64_t microseconds) {
        constexpr std::int64_t kBeyondAnyPulse = 1 << 20;
        return from_eighths(std::clamp(microseconds, -kBeyondAnyPulse, kBeyondAnyPulse) *
                            kEighthsPerMicrosecond);
    }

    /// Rounds to the nearest eighth. Not-a-number becomes 0.
    static Pulse from_fractional_microseconds(double microseconds) {
        constexpr double kBeyondAnyPulse = 1 << 20;
        if (std::isnan(microseconds)) {
            return Pulse{};
        }
        const double limited = std::clamp(microseconds, -kBeyondAnyPulse, kBeyondAnyPulse);
        return from_eighths(nearest_whole(limited * kEighthsPerMicrosecond));
    }

    constexpr std::int32_t eighths() const { return eighths_; }
    constexpr double microseconds() const {
        return static_cast<double>(eighths_) / kEighthsPerMicrosecond;
    }
    /// Rounds to the nearest whole microsecond that a pulse can have, halves upwards: at most 4095,
    /// because readers take 4096 for no pulse.
    constexpr std::int32_t whole_microseconds() const {
        constexpr std::int32_t kMost = std::numeric_limits<std::int16_t>::max() >> 3;
        return std::min((eighths_ + kEighthsPerMicrosecond / 2) >> 3, kMost);
    }

    constexpr auto operator<=>(const Pulse&) const = default;

  private:
    std::int16_t eighths_ = 0;
};

static_assert(sizeof(Pulse) == 2);

/// Stick centre of the usual scale; sent for an absent channel.
inline constexpr Pulse kCentrePulse = Pulse::from_microseconds(1500);
/// Values of a two-state channel (SBUS channels 17 and 18, a switch).
inline constexpr Pulse kSwitchOffPulse = Pulse::from_microseconds(1000);
inline constexpr Pulse kSwitchOnPulse = Pulse::from_microseconds(2000);

}  // namespace tribus
