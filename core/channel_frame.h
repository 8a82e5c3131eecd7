#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "core/link_cause.h"
#include "core/pulse.h"
#include "core/time.h"

namespace tribus {

/// Channels of the widest wire format: i.Bus has 18, SBUS 16 and two switches.
inline constexpr std::size_t kChannelCount = 18;

/// One bit for each channel.
inline constexpr std::uint32_t kAllChannels = (1U << kChannelCount) - 1;

/// The wire format that the values were first read from.
enum class Origin : std::uint8_t { none, ibus, sbus, dronecan, can, dbc, unknown };

/// Marks an unknown link quality. Known ones are 0 to 100 %.
inline constexpr std::uint8_t kNoLinkQuality = 0xFF;

/// One snapshot of the sticks: the content of one frame, independent of the wire format.
///
/// RC data is a state, not a stream: a newer frame replaces an older one. A default frame has no
/// channels and is marked failsafe. Channel numbers are zero-based here; users and files count from
/// 1. Pure; thread-bound.
class ChannelFrame {
  public:
    /// The values are old, but the link is up (SBUS flag 0x04; docs/protocols/sbus.md, "Flags").
    bool frame_lost = true;
    /// The link is down: the values are presets or held (SBUS flag 0x08). Separate from frame_lost
    /// because senders set each of them alone.
    bool failsafe = true;
    /// Index of the input that the frame came from.
    std::uint8_t source = 0;
    Origin origin = Origin::unknown;
    std::uint8_t link_quality = kNoLinkQuality;
    /// Cause of the state of the source input. Only set in the frames of an output.
    LinkCause cause = LinkCause::never_seen;
    /// Number of the frame within its input; wraps.
    std::uint32_t sequence = 0;
    /// When the last byte of the frame was read.
    Instant received{};

    /// Whether the values come from a live link.
    bool good() const { return !frame_lost && !failsafe; }

    /// One bit for each channel that is absent.
    std::uint32_t absent() const { return absent_; }
    bool has_any() const { return absent_ != kAllChannels; }
    /// Whether every channel of `other` is present here.
    bool has_all_of(const ChannelFrame& other) const { return (absent_ & ~other.absent_) == 0; }
    /// Whether the channel is present.
    bool has(std::size_t channel) const { return ((absent_ >> channel) & 1U) == 0; }
    /// Whether the first `count` channels are all present.
    bool has_first(std::size_t count) const { return (absent_ & ((1U << count) - 1)) == 0; }
    /// Value of a channel, or nothing if it is absent.
    std::optional<Pulse> channel(std::size_t channel) const {
        return has(channel) ? std::optional(pulses_[channel]) : std::nullopt;
    }
    Pulse channel_or(std::size_t channel, Pulse absent) const {
        return has(channel) ? pulses_[channel] : absent;
    }
    /// Sets a channel, which is present then.
    constexpr void set(std::size_t channel, Pulse pulse) {
        pulses_[channel] = pulse;
        absent_ &= ~(1U << channel);
    }
    void set(std::size_t channel, std::optional<Pulse> pulse) {
        if (pulse) {
            set(channel, *pulse);
        } else {
            remove(channel);
        }
    }
    /// Marks the first `count` channels as present, with the values that they have.
    void mark_first(std::size_t count) { absent_ &= ~((1U << count) - 1); }
    /// Marks these channels as absent, one bit each, and the others as present. Absent ones must
    /// have the pulse 0.
    void mark_only_absent(std::uint32_t channels) { absent_ = channels; }
    /// Makes a channel absent.
    void remove(std::size_t channel) {
        pulses_[channel] = Pulse{};
        absent_ |= 1U << channel;
    }

    /// Makes these channels absent, one bit each.
    void remove_all(std::uint32_t channels) {
        absent_ |= channels;
        for (; channels != 0; channels &= channels - 1) {
            pulses_[static_cast<std::size_t>(std::countr_zero(channels))] = Pulse{};
        }
    }

    /// Pulses of all channels; 0 for each absent one.
    const std::array<Pulse, kChannelCount>& pulses() const { return pulses_; }
    /// For writing many channels at once. Write only channels that are present.
    std::array<Pulse, kChannelCount>& pulses() { return pulses_; }

    /// Same channels and values; flags do not count.
    bool same_channels(const ChannelFrame& other) const {
        return pulses_ == other.pulses_ && absent_ == other.absent_;
    }
    /// Same channels, values and flags; source and time do not count.
    bool same_content(const ChannelFrame& other) const {
        return same_channels(other) && frame_lost == other.frame_lost && failsafe == other.failsafe;
    }

  private:
    std::array<Pulse, kChannelCount> pulses_{};
    std::uint32_t absent_ = kAllChannels;
};

static_assert(std::is_trivially_copyable_v<ChannelFrame>);
static_assert(sizeof(ChannelFrame) <= 64, "one frame fits one cache line");

}  // namespace tribus
