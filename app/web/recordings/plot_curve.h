#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/channel_frame.h"
#include "core/pulse.h"
#include "core/time.h"

/// Reduces a recording to what a picture of some columns of pixels can show. Pure.
namespace tribus::web {

/// The part of a recording that is drawn. Times count from its beginning.
struct PlotSpan {
    Duration from{};
    Duration to{};
    std::size_t columns = 0;

    /// The column that shows `at`, which must lie in [from, to).
    std::size_t column(Duration at) const {
        return static_cast<std::size_t>((at - from).count() * static_cast<std::int64_t>(columns) /
                                        (to - from).count());
    }
};

/// No recording is longer, so what lies behind is damaged.
inline constexpr Duration kLongestPlot = std::chrono::hours(4);
inline constexpr std::size_t kMostPlotColumns = 4000;

/// Least and greatest value in one column; least is above greatest if there was none.
struct PlotColumn {
    Pulse least = Pulse::from_eighths(std::numeric_limits<std::int16_t>::max());
    Pulse greatest = Pulse::from_eighths(std::numeric_limits<std::int16_t>::min());

    bool empty() const { return least > greatest; }
};

/// One channel over time. A value lasts until the next one or until `end`. Times never decrease.
class PlotCurve {
  public:
    explicit PlotCurve(const PlotSpan& span) : span_(span), columns_(span.columns) {}

    void set(Duration at, Pulse value);
    /// From `at` on there is none.
    void end(Duration at);
    std::span<const PlotColumn> columns() const { return columns_; }

  private:
    void cover(Duration begin, Duration end);

    PlotSpan span_;
    std::vector<PlotColumn> columns_;
    std::optional<Pulse> value_;
    Duration since_{};
};

/// The channels of one input or output. They end `gap` after a frame that no other followed.
class PlotFrames {
  public:
    PlotFrames(const PlotSpan& span, Duration gap) : span_(span), gap_(gap) {}

    /// Draws another part of the recording. Call it before the first frame.
    void show(const PlotSpan& span) { span_ = span; }
    void take(Duration at, const ChannelFrame& frame);
    /// The recording ends at `at`.
    void finish(Duration at);
    /// Null for a channel that never came.
    const PlotCurve* channel(std::size_t channel) const { return curves_[channel].get(); }

  private:
    void end_all(Duration at);

    PlotSpan span_;
    Duration gap_;
    std::optional<Duration> latest_;
    std::array<std::unique_ptr<PlotCurve>, kChannelCount> curves_;
};

struct PlotState {
    Duration from{};
    Duration to{};
    std::string_view word;
};

/// The states of one output over time, within the span. Times never decrease.
class PlotStates {
  public:
    explicit PlotStates(const PlotSpan& span) : span_(span) {}

    /// From `at` on it is in that state; `word` must outlive the object.
    void set(Duration at, std::string_view word);
    void finish(Duration at);
    const std::vector<PlotState>& states() const { return states_; }
    /// Number of those beyond kMost.
    std::size_t left_out() const { return left_out_; }

    static constexpr std::size_t kMost = 500;

  private:
    PlotSpan span_;
    std::optional<PlotState> present_;
    std::vector<PlotState> states_;
    std::size_t left_out_ = 0;
};

}  // namespace tribus::web
