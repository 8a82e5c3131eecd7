#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/line_words.h"
#include "pipelines/settings.h"

/// The filters of one pipeline. Each is a small struct; the set is closed.
namespace tribus {

/// This far around the centre reads as centre. What is beyond is stretched, so that there is no
/// step at the edge and 1000 and 2000 us stay.
struct DeadbandFilter {
    Pulse width;
    Pulse apply(Pulse pulse, Instant now);
};
/// A share of the cubic curve; 1000, 1500 and 2000 us stay, and so does what is beyond.
struct ExpoFilter {
    double share = 0;
    Pulse apply(Pulse pulse, Instant now);
};
/// Mirrored at 1500 us.
struct ReverseFilter {
    Pulse apply(Pulse pulse, Instant now);
};
struct TrimFilter {
    Pulse offset;
    Pulse apply(Pulse pulse, Instant now);
};
/// No faster than so much; starts at the first value that it sees.
struct SlewFilter {
    double eighths_per_nanosecond = 0;
    bool started = false;
    double latest_eighths = 0;
    Instant latest_at{};
    Pulse apply(Pulse pulse, Instant now);
};
struct LimitFilter {
    Pulse min;
    Pulse max;
    Pulse apply(Pulse pulse, Instant now);
};
using Filter =
    std::variant<DeadbandFilter, ExpoFilter, ReverseFilter, TrimFilter, SlewFilter, LimitFilter>;

/// Those outputs of a map that are an input channel, reversed, trimmed and limited at most, as
/// nearly all are: all at once. A value is limited first, in terms of the input, so that no step
/// can leave the range of a Pulse.
class StraightLanes {
  public:
    /// Every channel passes as it is.
    StraightLanes();
    /// Whether it could take the rule.
    bool take(const ChannelRule& rule);
    void apply(const ChannelFrame& input, ChannelFrame& output) const;

  private:
    /// Whole vectors of eight.
    static constexpr std::size_t kLanes = (kChannelCount + 7) / 8 * 8;
    using Lanes = std::array<std::int16_t, kLanes>;

    std::array<std::uint8_t, kChannelCount> input_{};
    Lanes least_{};
    Lanes most_{};
    Lanes turned_{};  ///< all bits where it is reversed, else none
    Lanes offset_{};
};

/// Makes the channels of an output from those of an input. Channels without a rule pass unchanged.
/// No allocation and no failure after construction. Thread-bound.
class ChannelMap {
  public:
    explicit ChannelMap(std::span<const ChannelRule> rules);

    /// Every channel reads from `input`, none from another output channel. A channel whose source
    /// is absent is absent. Flags, time and origin pass.
    ChannelFrame apply(const ChannelFrame& input, Instant now);

    /// What input lines say from now on.
    void set_lines(LineLevels levels) { lines_ = levels; }
    LineLevels lines() const { return lines_; }

    /// The output said `frame` instead (presets): a slew goes on from there.
    void restart_from(const ChannelFrame& frame, Instant now);

  private:
    /// Any lane but a straight one.
    struct Lane {
        std::size_t output = 0;
        ChannelSource source;
        std::vector<Filter> filters;
    };

    StraightLanes straight_lanes_;
    std::vector<Lane> lanes_;
    LineLevels lines_ = kNoLineActive;
};

}  // namespace tribus
