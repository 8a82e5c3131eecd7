#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "core/pulse.h"
#include "core/setting.h"

namespace tribus {

inline constexpr std::uint16_t kSbusRawMost = 2047;

/// The straight line between the 11-bit values of SBUS and pulses (ibus-sbus.md 3.7). Senders and
/// readers disagree about it, so it is a setting. Decoding then encoding gives the same raw value,
/// for all 2048. Pure and reentrant.
class SbusScale {
  public:
    /// Needs two different raw values and a slope that keeps neighbouring raw values apart
    /// (0.25 us or more); the configuration checks that.
    static SbusScale through(const TwoPoints& points);
    /// "betaflight", "ardupilot", "px4", "frsky" or "futaba".
    static std::optional<SbusScale> named(std::string_view name);
    /// By a setting's value: a name or two points. Betaflight's for anything else.
    static SbusScale from_setting(const SettingValue* value);

    Pulse decode(std::uint16_t raw) const {
        return Pulse::from_eighths((raw * decode_slope_ + decode_offset_) >> kFractionBits);
    }
    /// The nearest raw value, 0 to 2047.
    std::uint16_t encode(Pulse pulse) const;

  private:
    static constexpr int kFractionBits = 32;

    SbusScale(double slope_eighths, double offset_eighths);

    // Fixed point with 32 bits of fraction; the offsets hold the half for rounding.
    std::int64_t decode_slope_;
    std::int64_t decode_offset_;
    std::int64_t encode_slope_;
    std::int64_t encode_offset_;
};

}  // namespace tribus
