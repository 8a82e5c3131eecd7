#include "core/arrival_clock.h"

#include <algorithm>
#include <utility>

namespace tribus {
namespace {

/// Most arrivals that the fitted line weighs.
constexpr int kMostWeighed = 56;
/// The sender has changed its period if this many intervals in a row do not fit. Lost frames make
/// intervals longer, never shorter, so longer intervals need more evidence.
constexpr int kOutliersToRestart = 4;
constexpr int kLongOutliersToRestart = 16;
/// Share of an interval: a frame this close to its expected arrival fits, however small the
/// lateness.
constexpr int kGoodFit = 8;
/// Share of an interval: two errors this close to each other count as the same error.
constexpr int kSameError = 16;
/// Lateness rises by half of what a frame exceeds it, at most by this share of an interval, so that
/// one stall of the machine counts little. It falls by the third share per frame.
constexpr int kLatenessRise = 2;
constexpr int kLatenessStep = 64;
constexpr int kLatenessDecay = 128;
/// Share of an interval. A larger error tells more about the machine than about the sender: first
/// value once the line has its full memory, second value before.
constexpr int kErrorLimit = 16;
constexpr int kEarlyErrorLimit = 4;

}  // namespace

void ArrivalClock::arrived(Instant now) {
    const Duration delta = now - latest_;
    latest_ = now;
    if (!std::exchange(ever_, true)) {
        fitted_ = now;
        return;
    }
    if (interval_ == Duration::zero() || period_has_changed(delta)) {
        interval_ = delta;
        outliers_ = 0;
        steady_misfits_ = 0;
        restart_line(now);
    } else if (delta > interval_ / 2) {
        extend_line(now);
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
    const auto intervals = std::max<std::int64_t>((delta + interval_ / 2) / interval_, 1);
    const bool misfit = std::chrono::abs(delta - intervals * interval_) > interval_ / kGoodFit;
    const bool steady = std::chrono::abs(delta - latest_delta_) < interval_ / kSameError;
    steady_misfits_ = misfit && steady ? steady_misfits_ + 1 : 0;
    return outliers_ >= outliers_to_restart || steady_misfits_ >= kOutliersToRestart;
}

void ArrivalClock::restart_line(Instant now) {
    fitted_ = now;
    lateness_ = Duration::zero();
    weighed_ = 2;
    far_off_ = 0;
    off_by_ = Duration::zero();
}

/// Least-squares line through the arrivals with fading memory. The weight of a new arrival follows
/// from how many the line has seen. The line starts again if a second frame has the same error as
/// the one before, beyond the usual lateness, or if several frames in a row have a large error.
void ArrivalClock::extend_line(Instant now) {
    const auto intervals = std::max<std::int64_t>((now - fitted_ + interval_ / 2) / interval_, 1);
    const Instant expected = fitted_ + intervals * interval_;
    const Duration error = now - expected;
    far_off_ = std::chrono::abs(error) < interval_ / 4 ? 0 : far_off_ + 1;
    const bool beyond_jitter = std::chrono::abs(error) > interval_ / kGoodFit + 2 * lateness_;
    const bool as_before = std::chrono::abs(error - off_by_) < interval_ / kSameError;
    off_by_ = beyond_jitter ? error : Duration::zero();
    if (far_off_ >= kOutliersToRestart || (beyond_jitter && as_before)) {
        restart_line(now);
        return;
    }
    weighed_ = std::min(weighed_ + 1, kMostWeighed);
    const int weight = weighed_ * (weighed_ + 1);
    const Duration most = interval_ / (weighed_ < kMostWeighed ? kEarlyErrorLimit : kErrorLimit);
    const Duration limited = std::clamp(error, -most, most);
    fitted_ = expected + limited * (4 * weighed_ - 2) / weight;
    interval_ += limited * 6 / (weight * intervals);
    lateness_ += error > lateness_
                     ? std::min((error - lateness_) / kLatenessRise, interval_ / kLatenessStep)
                     : -lateness_ / kLatenessDecay;
}

}  // namespace tribus
