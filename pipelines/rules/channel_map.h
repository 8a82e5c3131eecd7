#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/rules/channel_lanes.h"
#include "pipelines/rules/line_words.h"
#include "pipelines/rules/settings.h"

/// The filters of a channel map. Each is a small struct; the set is closed.
namespace tribus {

/// A pulse between two filters, in eighths of a microsecond. It may lie outside of the range of
/// Pulse: only the end of a channel's steps limits it.
using WidePulse = std::int32_t;

/// Pulses within `width` of 1500 us become 1500 us. Pulses beyond are stretched, so that there is
/// no step at the edge, and 1000 and 2000 us stay.
struct DeadbandFilter {
    Pulse width;
    WidePulse apply(WidePulse pulse, Instant now);
};
/// Blends in a share of a cubic curve. 1000, 1500 and 2000 us stay, and so do pulses beyond.
struct ExpoFilter {
    double share = 0;
    WidePulse apply(WidePulse pulse, Instant now);
};
/// Mirrors at 1500 us.
struct ReverseFilter {
    WidePulse apply(WidePulse pulse, Instant now);
};
struct TrimFilter {
    Pulse offset;
    WidePulse apply(WidePulse pulse, Instant now);
};
/// Limits the rate of change. Starts at the first value that it gets. Does not leave the range of
/// Pulse, so that it is never far behind a mix that does.
struct SlewFilter {
    double eighths_per_nanosecond = 0;
    bool started = false;
    double latest_eighths = 0;
    Instant latest_at{};
    WidePulse apply(WidePulse pulse, Instant now);
    /// The time before `until` does not count as time to move.
    void rest(Instant until) { latest_at = std::max(latest_at, until); }
};
struct LimitFilter {
    Pulse min;
    Pulse max;
    WidePulse apply(WidePulse pulse, Instant now);
};
using Filter =
    std::variant<DeadbandFilter, ExpoFilter, ReverseFilter, TrimFilter, SlewFilter, LimitFilter>;

/// The output channels of a map that are at most a reversed, trimmed and limited input channel,
/// which nearly all are. Computes all of them at once. Limits are converted to the input and
/// applied first, so that no step can leave the range of a Pulse.
class StraightLanes {
  public:
    /// Passes every channel unchanged.
    StraightLanes();
    /// Takes the rule if it can. Returns false if it cannot.
    bool take(const ChannelRule& rule);
    /// `output` is a copy of `input`.
    void apply(const ChannelFrame& input, ChannelFrame& output) {
        if (!unchanged_) {
            change(input, output);
        }
    }

  private:
    void change(const ChannelFrame& input, ChannelFrame& output);
    void change_group(std::size_t group, const ChannelFrame& from, ChannelFrame& to) const;
    void change_all(const ChannelFrame& from, ChannelFrame& to) const;
    void change_gathered(const ChannelFrame& input, ChannelFrame& output) const;
    void look_who_is_absent(std::uint32_t absent);

    std::array<std::uint8_t, kChannelCount> input_{};
    bool unchanged_ = true;  ///< every channel passes as it is
    bool in_place_ = true;   ///< no channel reads another one
    /// Absent channels of the latest input, and of the output with it, one bit each.
    std::uint32_t absent_in_ = 0;
    std::uint32_t absent_out_ = 0;
    ChannelNumbers present_out_ = present_channels(0);
    ChannelNumbers least_ = ChannelNumbers(INT16_MIN);
    ChannelNumbers most_ = ChannelNumbers(INT16_MAX);
    /// All bits set if the channel is reversed, else zero; and what is added then.
    ChannelNumbers turned_;
    ChannelNumbers offset_;
};

/// Makes the channels of an output from those of an input. Channels without a rule pass unchanged.
/// Does not allocate or fail after construction. Thread-bound.
class ChannelMap {
  public:
    explicit ChannelMap(std::span<const ChannelRule> rules);

    /// Every channel reads from `input`, never from another output channel. It is absent if its
    /// source is absent. Flags, time and origin pass.
    void apply(const ChannelFrame& input, ChannelFrame& output, Instant now) {
        output = input;
        straight_lanes_.apply(input, output);
        if (!lanes_.empty()) {
            apply_lanes(input, output, now);
        }
    }
    ChannelFrame apply(const ChannelFrame& input, Instant now) {
        ChannelFrame output;
        apply(input, output, now);
        return output;
    }

    /// What `apply` would make without slews. Moves none.
    ChannelFrame aim(const ChannelFrame& input) const;

    /// Sets the levels of the input lines.
    void set_lines(LineLevels levels) { lines_ = levels; }
    LineLevels lines() const { return lines_; }

    /// The output sent `frame` instead (presets): slews of these channels, one bit each, continue
    /// from there.
    void restart_from(const ChannelFrame& frame, Instant now,
                      std::uint32_t channels = kAllChannels) {
        if (!lanes_.empty()) {
            restart_lanes(frame, now, channels);
        }
    }
    /// Slews do not count the time before `until` as time to move: the output held its values.
    void rest(Instant until);
    /// The limit of the rate of change of a channel, in eighths of a microsecond per nanosecond.
    /// `nullopt`: it has none.
    std::optional<double> slew_of(std::size_t channel) const;
    bool has_slews() const;

  private:
    /// A channel that StraightLanes cannot take.
    struct Lane {
        std::size_t output = 0;
        ChannelSource source;
        std::vector<Filter> filters;
    };

    void apply_lanes(const ChannelFrame& input, ChannelFrame& output, Instant now);
    void restart_lanes(const ChannelFrame& frame, Instant now, std::uint32_t channels);
    template <class Action>
    void for_each_slew(Action action);

    StraightLanes straight_lanes_;
    std::vector<Lane> lanes_;
    LineLevels lines_ = kNoLineActive;
};

}  // namespace tribus
