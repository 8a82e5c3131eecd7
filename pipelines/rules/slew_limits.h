#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/rules/channel_map.h"

namespace tribus {

/// Keeps an output within the slews in the maps of its inputs: between two of its frames, no
/// channel moves faster than the slew in the map of the input in control. The input's own slew does
/// not ensure that, since it may go on for other outputs while this one holds its values. Pure.
/// Thread-bound. No allocation after the last `add`.
class SlewLimits {
  public:
    /// Adds the next input. `map` may be null: the input has none.
    void add(const ChannelMap* map);
    /// Whether any input has a slew.
    bool any() const { return any_; }

    /// Starts from `frame`: values of which the next ones may be only so far away.
    void start(const ChannelFrame& frame);
    /// Limits a frame of the input that was added as number `place`, after so much time.
    void apply(ChannelFrame& frame, std::size_t place, Duration passed);
    /// The same for a frame that is made from several inputs: a channel that all of them limit
    /// moves no faster than the fastest of them.
    void apply_to_all(ChannelFrame& frame, Duration passed);

  private:
    /// Eighths of a microsecond per nanosecond. `nullopt`: no limit.
    using Rates = std::array<std::optional<double>, kChannelCount>;

    void limit(ChannelFrame& frame, const Rates& rates, Duration passed);

    std::vector<Rates> rates_;
    Rates fastest_{};
    bool any_ = false;
    /// In eighths. `nullopt`: the channel was absent.
    std::array<std::optional<double>, kChannelCount> reached_{};
};

}  // namespace tribus
