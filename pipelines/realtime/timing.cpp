#include "pipelines/realtime/timing.h"

namespace tribus {
namespace {

/// A frame that is late by more than period / kMissShare has missed its deadline.
constexpr int kMissShare = 10;

}  // namespace

void InputTiming::frame_came(Instant now) {
    if (latest_ != Instant{}) {
        age_.record(now - latest_, now);
    }
    latest_ = now;
}

void OutputTiming::frame_went(const FrameTimes& times) {
    const Duration late = times.taken - times.due;
    lateness_.record(late, times.handed_over);
    if (late > times.period / kMissShare) {
        deadline_misses_.store(deadline_misses() + 1, std::memory_order_relaxed);
    }
    if (times.read != latest_read_ && times.read != Instant{}) {
        latest_read_ = times.read;
        latency_.record(times.handed_over - times.read, times.handed_over);
    }
}

}  // namespace tribus
