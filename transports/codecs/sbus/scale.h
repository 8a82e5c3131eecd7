#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/channel_frame.h"
#include "core/pulse.h"
#include "core/setting.h"
#include "transports/codecs/wire_words.h"

namespace tribus {

inline constexpr std::uint16_t kSbusRawMost = 2047;
/// Channels with a raw value in a frame. Channels 17 and 18 are only on or off.
inline constexpr std::size_t kSbusChannels = 16;
using SbusRaw = std::array<std::uint16_t, kSbusChannels>;
/// The raw values of a frame as vectors.
struct SbusLanes {
    Lanes first;
    Lanes last;
};
inline SbusRaw from_lanes(const SbusLanes& lanes) {
    return std::bit_cast<SbusRaw>(lanes);
}

/// The straight line between the 11-bit values of SBUS and pulses (docs/protocols/sbus.md,
/// "Scales"). Senders and receivers disagree about it, so it is a setting. Decoding and then
/// encoding gives back all 2048 raw values. Pure and reentrant.
class SbusScale {
  public:
    /// The two raw values must differ, and the slope must keep neighbouring raw values apart (0.25
    /// us or more); the configuration checks that.
    static SbusScale through(const TwoPoints& points);
    /// Accepts "betaflight", "ardupilot", "px4", "frsky" and "futaba".
    static std::optional<SbusScale> named(std::string_view name);
    /// The scale of a setting: a name or two points. Betaflight's scale for anything else.
    static SbusScale from_setting(const SettingValue* value);

    Pulse decode(std::uint16_t raw) const {
        return Pulse::from_eighths((raw * decode_slope_ + decode_offset_) >> kFractionBits);
    }
    /// The nearest raw value, 0 to 2047.
    std::uint16_t encode(Pulse pulse) const;

    /// Convert all channels of a frame. To encode, all must be present.
    void decode_each(const SbusRaw& raw, ChannelFrame& channels) const;
    SbusRaw encode_each(const ChannelFrame& channels) const;

    /// Whether a raw step is a whole number of eighths, as in three of the five named scales. Then
    /// 16-bit arithmetic gives the same result, several times faster; the constructor checks
    /// that it does.
    bool whole_steps() const { return whole_steps_; }
    /// Like the functions above. Only if the steps are whole; to encode, all channels must be
    /// present.
    void decode_whole(const SbusLanes& raw, ChannelFrame& channels) const {
        auto& pulses = channels.pulses();
        store_numbers(&pulses[0], decode_whole(raw.first));
        store_numbers(&pulses[kLanes], decode_whole(raw.last));
    }
    SbusRaw encode_whole(const ChannelFrame& channels) const {
        SbusRaw raw;
        for (std::size_t first = 0; first < kSbusChannels; first += kLanes) {
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const std::int32_t eighths = channels.pulses()[first + lane].eighths();
                raw[first + lane] = encode_whole(lane, static_cast<std::int16_t>(eighths));
            }
        }
        return raw;
    }

  private:
    static constexpr int kFractionBits = 32;

    SbusScale(double slope_eighths, double offset_eighths);

    SignedLanes decode_whole(Lanes raw) const {
        return reinterpret_cast<SignedLanes>(raw * whole_.step +
                                             reinterpret_cast<Lanes>(whole_.least));
    }
    /// Divides by the step by multiplying with its reciprocal.
    std::uint16_t encode_whole(std::size_t lane, std::int16_t eighths) const {
        const auto inside =
            std::clamp<std::int16_t>(eighths, whole_.least[lane], whole_.most[lane]);
        const auto rounded = static_cast<std::uint16_t>(inside + whole_.rounding[lane]);
        return static_cast<std::uint16_t>((std::uint32_t{rounded} * whole_.per_step[lane]) >> 16U);
    }
    bool whole_steps_are_exact() const;

    // Fixed point with 32 bits of fraction. The offsets include the half for rounding.
    std::int64_t decode_slope_;
    std::int64_t decode_offset_;
    std::int64_t encode_slope_;
    std::int64_t encode_offset_;

    /// For whole steps, in eighths. Every lane has the same value.
    struct WholeSteps {
        Lanes step{};
        SignedLanes least{};
        SignedLanes most{};
        Lanes rounding{};  ///< moves `least` to half a step
        Lanes per_step{};  ///< 2^16 / step, rounded up
    };
    WholeSteps whole_;
    bool whole_steps_ = false;
};

}  // namespace tribus
