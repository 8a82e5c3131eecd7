#include "core/arrival_clock.h"

#include <algorithm>
#include <utility>

namespace tribus {
namespace {

/// Arrivals that the line through them remembers: as many as there were, up to this.
constexpr int kMemory = 56;
/// So many intervals in a row that do not fit mean that the sender has changed its period. Lost
/// frames make intervals longer, never shorter, so for longer ones more have to agree.
constexpr int kOutliersToRestart = 4;
constexpr int kLongOutliersToRestart = 16;
/// Share of an interval within which a frame fits the beat, however little frames are late.
constexpr int kOnBeat = 8;
/// Share of an interval within which two frames miss it by the same.
constexpr int kSameError = 16;
/// How fast the lateness of frames is believed, half of it but no more than this share of an
/// interval, so that a single stall of the machine counts little; and how fast it is forgotten.
constexpr int kLatenessRise = 2;
constexpr int kLatenessStep = 64;
constexpr int kLatenessDecay = 128;
/// Share of an interval beyond which an error says more of the machine than of the sender, once the
/// rhythm is known, and before.
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

/// Counts this one too. Either none of the latest frames came after an interval, or each after the
/// same time that is no whole number of intervals. The latter is needed as well: a rhythm of 5.6 ms
/// through frames that come each 7 ms looks as if every fifth were missing.
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

/// The line of least squares through arrivals, with fading memory: what one more of them says of
/// the place of the latest and of the interval weighs as its number demands. A sender that begins
/// anew shows it by a second frame that misses the beat by the same as the one before, and by more
/// than frames are late anyway; or by several that miss it by far.
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
