#pragma once

#include <array>
#include <bitset>

#include "core/channel_frame.h"
#include "core/time.h"

namespace tribus {

/// Leads the channels of an output from what it said to what it is to say, no faster than so much,
/// instead of jumping. A channel that has arrived is free. Pure; thread-bound.
class Glide {
  public:
    /// From the channels of `from` on, which were said at `now`.
    void start(const ChannelFrame& from, double us_per_second, Instant now);
    void stop() { under_way_.reset(); }
    /// Channels that are still under way get the value that they have reached; absent ones stay
    /// absent, and are free.
    void apply(ChannelFrame& frame, Instant now);

  private:
    double eighths_per_nanosecond_ = 0;
    Instant latest_at_{};
    std::array<double, kChannelCount> reached_eighths_{};
    std::bitset<kChannelCount> under_way_;
};

}  // namespace tribus
