#pragma once

#include <span>
#include <variant>
#include <vector>

#include "core/channel_frame.h"
#include "core/time.h"
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

/// Makes the channels of an output from those of an input. Channels without a rule pass unchanged.
/// No allocation and no failure after construction. Thread-bound.
class ChannelMap {
  public:
    explicit ChannelMap(std::span<const ChannelRule> rules);

    /// Every channel reads from `input`, none from another output channel. A channel whose source
    /// is absent is absent. Flags, time and origin pass.
    ChannelFrame apply(const ChannelFrame& input, Instant now);

    /// The output said `frame` instead (presets): a slew goes on from there.
    void restart_from(const ChannelFrame& frame, Instant now);

  private:
    struct Lane {
        std::size_t output = 0;
        ChannelSource source;
        std::vector<Filter> filters;
    };
    std::vector<Lane> lanes_;
};

}  // namespace tribus
