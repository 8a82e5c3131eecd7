#include "core/arrival_clock.h"

#include <algorithm>
#include <utility>

namespace tribus {
namespace {

/// Most arrivals that the fitted line weighs.
constexpr int kMemory = 56;
/// The sender has changed its period if this many intervals in a row do not fit. Lost frames make
/// intervals longer, never shorter, so longer intervals need more evidence.
constexpr int kOutliersToRestart = 4;
constexpr int kLongOutliersToRestart = 16;
/// Share of an interval: a frame this close to its expected arrival fits, however small the
/// lateness.
constexpr int kOnBeat = 8;
/// Share of an interval: two errors this close to each other count as the same error.
constexpr int kSameError = 16;
/// Lateness rises by half of what a frame exceeds it, at most by this share of an interval, so that
/// one stall of the machine counts little. It falls by the third share per frame.
constexpr int kLatenessRise = 2;
constexpr int kLatenessStep = 64;
constexpr int kLatenessDecay = 128;
/// Share of an interval. A larger error tells more about the machine than about the sender: first
/// value once the line has its full memory, second value before.
constexpr int kMostError = 16;
constexpr int kMostEarlyError = 4;

}  // namespace

void ArrivalClock::arrived(Instant now) {
    const Duration delta = now - latest_;
    latest_ = now;
    if (!std::exchange(ever_, true)) {
        rhythm_ = now;
        return;
    }
    if (interval_ == Duration::zero() || period_has_changed(delta)) {
        interval_ = delta;
        outliers_ = 0;
        steady_misfits_ = 0;
        begin_rhythm(now);
    } else if (delta > interval_ / 2) {
        follow_rhythm(now);
    }
    latest_delta_ = delta;
}

/// Counts `delta` too. True if a run of frames came at no interval, or if a run came at one steady
/// time that is no whole number of intervals. The second test is needed as well: a line of 5.6 ms
/// through frames that come every 7 ms looks as if every fifth frame were missing.
bool ArrivalClock::period_has_changed(Duration delta) {
    const bool fits = delta > interval_ / 2 && delta < interval_ + interval_ / 2;
    const int outliers_to_restart = delta > interval_ ? kLongOutliersToRestart : kOutliersToRestart;
    outliers_ = fits ? 0 : outliers_ + 1;
    const auto beats = std::max<std::int64_t>((delta + interval_ / 2) / interval_, 1);
    const bool misfit = std::chrono::abs(delta - beats * interval_) > interval_ / kOnBeat;
    const bool steady = std::chrono::abs(delta - latest_delta_) < interval_ / kSameError;
    steady_misfits_ = misfit && steady ? steady_misfits_ + 1 : 0;
    return outliers_ >= outliers_to_restart || steady_misfits_ >= kOutliersToRestart;
}

void ArrivalClock::begin_rhythm(Instant now) {
    rhythm_ = now;
    lateness_ = Duration::zero();
    remembered_ = 2;
    off_beat_ = 0;
    off_by_ = Duration::zero();
}

/// Least-squares line through the arrivals with fading memory. The weight of a new arrival follows
/// from how many the line has seen. The line starts again if a second frame has the same error as
/// the one before, beyond the usual lateness, or if several frames in a row have a large error.
void ArrivalClock::follow_rhythm(Instant now) {
    const auto beats = std::max<std::int64_t>((now - rhythm_ + interval_ / 2) / interval_, 1);
    const Instant beat = rhythm_ + beats * interval_;
    const Duration error = now - beat;
    off_beat_ = std::chrono::abs(error) < interval_ / 4 ? 0 : off_beat_ + 1;
    const bool beyond_jitter = std::chrono::abs(error) > interval_ / kOnBeat + 2 * lateness_;
    const bool as_before = std::chrono::abs(error - off_by_) < interval_ / kSameError;
    off_by_ = beyond_jitter ? error : Duration::zero();
    if (off_beat_ >= kOutliersToRestart || (beyond_jitter && as_before)) {
        begin_rhythm(now);
        return;
    }
    remembered_ = std::min(remembered_ + 1, kMemory);
    const int weight = remembered_ * (remembered_ + 1);
    const Duration most = interval_ / (remembered_ < kMemory ? kMostEarlyError : kMostError);
    const Duration believed = std::clamp(error, -most, most);
    rhythm_ = beat + believed * (4 * remembered_ - 2) / weight;
    interval_ += believed * 6 / (weight * beats);
    lateness_ += error > lateness_
                     ? std::min((error - lateness_) / kLatenessRise, interval_ / kLatenessStep)
                     : -lateness_ / kLatenessDecay;
}

}  // namespace tribus
