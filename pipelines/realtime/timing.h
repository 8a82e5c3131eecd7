#pragma once

#include <atomic>
#include <cstdint>

#include "core/time.h"
#include "pipelines/realtime/histogram.h"

namespace tribus {

/// Times of an input. The data thread records, any thread may read.
class InputTiming {
  public:
    /// A frame came at `now`.
    void frame_came(Instant now);

    /// Age of the latest frame when the next one came.
    const Histogram& age() const { return age_; }

  private:
    Histogram age_;
    Instant latest_{};
};

/// Times of one frame of an output.
struct FrameTimes {
    Instant due{};
    /// When its values were taken.
    Instant taken{};
    /// When it was handed over to the kernel.
    Instant handed_over{};
    /// When the input's frame with these values was read. Zero for presets.
    Instant read{};
    Duration period{};
};

/// Times of an output. The data thread records, any thread may read.
class OutputTiming {
  public:
    /// A frame was handed over.
    void frame_went(const FrameTimes& times);

    /// From due to taken.
    const Histogram& lateness() const { return lateness_; }
    /// From the read of an input's frame to the first hand-over of its values.
    const Histogram& latency() const { return latency_; }
    /// Frames that were late by more than a tenth of the period.
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
