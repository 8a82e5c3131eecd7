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
    const Duration delta = now - line_.latest;
    line_.latest = now;
    if (continues_line(now, delta)) {
        latest_delta_ = delta;
        return;
    }
    if (!std::exchange(ever_, true)) {
        line_.fitted = now;
        return;
    }
    if (line_.interval == Duration::zero() || period_has_changed(delta)) {
        line_.interval = delta;
        outliers_ = 0;
        steady_misfits_ = 0;
        restart_line(now);
    } else if (delta > line_.interval / 2) {
        extend_line(now);
    }
    latest_delta_ = delta;
}

/// The usual case, without a division: the line has its full memory, and a frame came one interval
/// after the one before, near the line. Returns false, and does nothing, in every other case.
bool ArrivalClock::continues_line(Instant now, Duration delta) {
    const Duration error = now - line_.fitted - line_.interval;
    const Duration most = line_.interval / kGoodFit;
    if (weighed_ != kMostWeighed || std::chrono::abs(delta - line_.interval) > most ||
        std::chrono::abs(error) > most) {
        return false;
    }
    outliers_ = 0;
    steady_misfits_ = 0;
    far_off_ = 0;
    off_by_ = Duration::zero();
    constexpr int kWeight = kMostWeighed * (kMostWeighed + 1);
    const Duration limit = line_.interval / kErrorLimit;
    const Duration limited = std::clamp(error, -limit, limit);
    line_.fitted += line_.interval + limited * (4 * kMostWeighed - 2) / kWeight;
    line_.interval += limited * 6 / kWeight;
    follow(error);
    return true;
}

/// Counts `delta` too. True if a run of frames came at no interval, or if a run came at one steady
/// time that is no whole number of intervals. The second test is needed as well: a line of 5.6 ms
/// through frames that come every 7 ms looks as if every fifth frame were missing.
bool ArrivalClock::period_has_changed(Duration delta) {
    const bool fits = delta > line_.interval / 2 && delta < line_.interval + line_.interval / 2;
    const int outliers_to_restart =
        delta > line_.interval ? kLongOutliersToRestart : kOutliersToRestart;
    outliers_ = fits ? 0 : outliers_ + 1;
    const auto intervals = std::max<std::int64_t>((delta + line_.interval / 2) / line_.interval, 1);
    const bool misfit =
        std::chrono::abs(delta - intervals * line_.interval) > line_.interval / kGoodFit;
    const bool steady = std::chrono::abs(delta - latest_delta_) < line_.interval / kSameError;
    steady_misfits_ = misfit && steady ? steady_misfits_ + 1 : 0;
    return outliers_ >= outliers_to_restart || steady_misfits_ >= kOutliersToRestart;
}

void ArrivalClock::restart_line(Instant now) {
    line_.fitted = now;
    line_.lateness = Duration::zero();
    weighed_ = 2;
    far_off_ = 0;
    off_by_ = Duration::zero();
}

/// Least-squares line through the arrivals with fading memory. The weight of a new arrival follows
/// from how many the line has seen. The line starts again if a second frame has the same error as
/// the one before, beyond the usual lateness, or if several frames in a row have a large error.
void ArrivalClock::extend_line(Instant now) {
    const auto intervals =
        std::max<std::int64_t>((now - line_.fitted + line_.interval / 2) / line_.interval, 1);
    const Instant expected = line_.fitted + intervals * line_.interval;
    const Duration error = now - expected;
    far_off_ = std::chrono::abs(error) < line_.interval / 4 ? 0 : far_off_ + 1;
    const bool beyond_jitter =
        std::chrono::abs(error) > line_.interval / kGoodFit + 2 * line_.lateness;
    const bool as_before = std::chrono::abs(error - off_by_) < line_.interval / kSameError;
    off_by_ = beyond_jitter ? error : Duration::zero();
    if (far_off_ >= kOutliersToRestart || (beyond_jitter && as_before)) {
        restart_line(now);
        return;
    }
    weighed_ = std::min(weighed_ + 1, kMostWeighed);
    const int weight = weighed_ * (weighed_ + 1);
    const Duration most =
        line_.interval / (weighed_ < kMostWeighed ? kEarlyErrorLimit : kErrorLimit);
    const Duration limited = std::clamp(error, -most, most);
    line_.fitted = expected + limited * (4 * weighed_ - 2) / weight;
    line_.interval += limited * 6 / (weight * intervals);
    follow(error);
}

void ArrivalClock::follow(Duration error) {
    line_.lateness += error > line_.lateness ? std::min((error - line_.lateness) / kLatenessRise,
                                                        line_.interval / kLatenessStep)
                                             : -line_.lateness / kLatenessDecay;
}

}  // namespace tribus
