#pragma once

#include <algorithm>
#include <array>
#include <bitset>

#include "core/channel_frame.h"
#include "core/time.h"

namespace tribus {

/// Moves the channels of an output from its latest frame to new values at a limited rate, instead
/// of a jump. A channel that has arrived is no longer limited. Pure. Thread-bound.
class Glide {
  public:
    /// Starts from the channels of `from`, which were sent at `now`.
    void start(const ChannelFrame& from, double us_per_second, Instant now);
    /// The same on the way to other values: a lower limit that is still under way remains.
    void start_anew(const ChannelFrame& from, double us_per_second, Instant now);
    /// Goes on from what was reached, at another rate.
    void set_rate(double us_per_second);
    /// Ends the limit for all channels.
    void stop() { under_way_.reset(); }
    /// The time before `until` does not count as time to move: the output held its values.
    void rest(Instant until) { latest_at_ = std::max(latest_at_, until); }
    /// Sets the channels that have not arrived to the values that they have reached. A channel that
    /// is absent in `frame` stays absent and is no longer limited.
    void apply(ChannelFrame& frame, Instant now) {
        if (under_way_.any()) {
            move(frame, now);
        }
    }
    /// Sets them to the values that they have reached, and moves none.
    void show(ChannelFrame& frame) const;

  private:
    void move(ChannelFrame& frame, Instant now);

    double eighths_per_nanosecond_ = 0;
    Instant latest_at_{};
    std::array<double, kChannelCount> reached_eighths_{};
    std::bitset<kChannelCount> under_way_;
};

}  // namespace tribus
