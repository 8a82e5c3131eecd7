#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "core/pulse.h"
#include "core/time.h"

namespace tribus {

/// As many channels as the widest wire format has: i.Bus 18, SBUS 16 and two switches.
inline constexpr std::size_t kChannelCount = 18;

/// The format that values came in on at first, as far as it is known.
enum class Origin : std::uint8_t { none, ibus, sbus, dronecan, can, dbc, unknown };

/// Where nobody has told a link quality, which is 0 to 100 %.
inline constexpr std::uint8_t kNoLinkQuality = 0xFF;

/// One snapshot of the sticks: the meaning of one frame, whatever wire it came on.
///
/// RC data is a state, not a stream: a newer frame replaces an older one. A default frame has no
/// channel and says failsafe. Channel numbers are zero-based here; people and files count from 1.
class ChannelFrame {
  public:
    /// The values are old but the link is still up (SBUS flag 0x04).
    bool frame_lost = true;
    /// The link is down: the values are presets or held (SBUS flag 0x08). Kept apart from
    /// frame_lost because senders set them apart.
    bool failsafe = true;
    /// Index of the input that it came from.
    std::uint8_t source = 0;
    Origin origin = Origin::unknown;
    std::uint8_t link_quality = kNoLinkQuality;
    /// Counts the frames of one input, wrapping.
    std::uint32_t sequence = 0;
    /// When the last byte of the frame was read.
    Instant received{};

    bool good() const { return !frame_lost && !failsafe; }

    bool has(std::size_t channel) const { return ((present_ >> channel) & 1U) != 0; }
    /// Whether none of the first `count` channels is absent.
    bool has_first(std::size_t count) const {
        const std::uint32_t first = (1U << count) - 1;
        return (present_ & first) == first;
    }
    std::optional<Pulse> channel(std::size_t channel) const {
        return has(channel) ? std::optional(pulses_[channel]) : std::nullopt;
    }
    Pulse channel_or(std::size_t channel, Pulse absent) const {
        return has(channel) ? pulses_[channel] : absent;
    }
    void set(std::size_t channel, Pulse pulse) {
        pulses_[channel] = pulse;
        present_ |= 1U << channel;
    }
    void set(std::size_t channel, std::optional<Pulse> pulse) {
        if (pulse) {
            set(channel, *pulse);
        } else {
            remove(channel);
        }
    }
    /// The first `Count` channels at once, in eighths of a microsecond. There may be more numbers,
    /// which are 0: channels that are absent before.
    template <std::size_t Count, std::size_t Numbers>
    void set_first(const std::array<std::int16_t, Numbers>& eighths) {
        static_assert(Count <= Numbers && Numbers <= kChannelCount);
        for (std::size_t channel = 0; channel < Numbers; ++channel) {
            pulses_[channel] = Pulse::from_eighths(eighths[channel]);
        }
        present_ |= (1U << Count) - 1;
    }
    void remove(std::size_t channel) {
        pulses_[channel] = Pulse{};
        present_ &= ~(1U << channel);
    }

    /// Of all channels; those of absent ones mean nothing.
    const std::array<Pulse, kChannelCount>& pulses() const { return pulses_; }

    /// Same channels and flags; where and when it came from does not count.
    bool same_content(const ChannelFrame& other) const {
        return pulses_ == other.pulses_ && present_ == other.present_ &&
               frame_lost == other.frame_lost && failsafe == other.failsafe;
    }

  private:
    std::array<Pulse, kChannelCount> pulses_{};
    std::uint32_t present_ = 0;
};

static_assert(std::is_trivially_copyable_v<ChannelFrame>);
static_assert(sizeof(ChannelFrame) <= 64, "one frame fits one cache line");

}  // namespace tribus
