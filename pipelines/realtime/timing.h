#pragma once

#include <atomic>
#include <cstdint>

#include "core/time.h"
#include "pipelines/realtime/histogram.h"

namespace tribus {

/// Measured all the time, by the data thread; any thread may read.
class InputTiming {
  public:
    /// A frame came at `now`.
    void frame_came(Instant now);

    /// How old its latest frame had become when the next one came.
    const Histogram& age() const { return age_; }

  private:
    Histogram age_;
    Instant latest_{};
};

/// The way of one frame out.
struct FrameTimes {
    Instant due{};
    /// When the values were taken that it carries.
    Instant taken{};
    /// When the kernel had it.
    Instant handed_over{};
    /// When the input's frame was read that the values are from; zero for presets.
    Instant read{};
    Duration period{};
};

/// Measured all the time, by the data thread; any thread may read.
class OutputTiming {
  public:
    void frame_went(const FrameTimes& times);

    /// From when a frame was due to when its values were taken.
    const Histogram& lateness() const { return lateness_; }
    /// From reading an input's frame to having handed over its values, the first time.
    const Histogram& latency() const { return latency_; }
    /// Frames that were late by more than a tenth of their period.
    std::uint64_t deadline_misses() const {
        return deadline_misses_.load(std::memory_order_relaxed);
    }

  private:
    Histogram lateness_;
    Histogram latency_;
    std::atomic<std::uint64_t> deadline_misses_{0};
    Instant latest_read_{};
};

}  // namespace tribus
