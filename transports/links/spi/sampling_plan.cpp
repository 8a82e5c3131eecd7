#include "transports/links/spi/sampling_plan.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>

namespace tribus {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// While the rhythm is not known. It has the begin of a burst of each sender that is not slower.
constexpr Duration kSearchBlock = milliseconds(20);
/// Of several lengths, so that blocks do not go on ending within bursts.
constexpr int kSearchBlocks = 5;
constexpr Duration kSearchStep = microseconds(1700);
/// Periods of senders of RC frames, with some room: 3.8 ms (S.BUS "fast" of some) to 22 ms.
constexpr Duration kLeastPeriod = milliseconds(3);
constexpr Duration kMostPeriod = milliseconds(30);
/// A block ends so much later than without jitter: clocks differ, and the last byte must be known
/// as the last one.
constexpr Duration kLateBy = microseconds(250);
/// Of a sender that is not known yet.
constexpr Duration kFirstJitter = milliseconds(1);
constexpr int kJitterDecay = 512;
/// A rhythm with so many missing bursts is none any more.
constexpr int kMostMissed = 2;
constexpr int kMostDeaf = 4;

bool is_period(Duration interval) {
    return interval >= kLeastPeriod && interval <= kMostPeriod;
}

Duration absolute(Duration duration) {
    return duration < Duration::zero() ? -duration : duration;
}

}  // namespace

SamplingPlan::SamplingPlan(Duration longest) : longest_(longest) {}

/// Half of the pause at most: a block that ends later would end in the next burst.
Duration SamplingPlan::late_by() const {
    const Duration pause = std::max(period_ - length_, Duration::zero());
    return std::min(kLateBy + jitter_, pause / 2);
}

/// The first that begins after now: one whose begin is over is lost.
Instant SamplingPlan::next_burst(Instant now) const {
    const auto periods = std::max<std::int64_t>((now - *latest_) / period_, 0) + 1;
    return *latest_ + periods * period_;
}

Duration SamplingPlan::pause(Instant now) const {
    return follows() ? next_burst(now) - late_by() - now : Duration::max();
}

Duration SamplingPlan::next(Instant now) const {
    if (!follows()) {
        return std::min(kSearchBlock + deaf_ % kSearchBlocks * kSearchStep, longest_);
    }
    const Instant expected = next_burst(now);
    const Duration to_its_end = expected + length_ + late_by() - now;
    const Duration to_the_pause = expected - late_by() - now;
    return to_its_end <= longest_             ? to_its_end
           : to_the_pause <= Duration::zero() ? longest_
                                              : std::min(to_the_pause, longest_);
}

void SamplingPlan::found(const SampledBurst& burst) {
    if (!burst.cut) {
        length_ = burst.end - burst.begin;
        whole_ = true;
    }
    if (!follows()) {
        begin_rhythm(burst.begin);
        return;
    }
    const auto periods = (burst.begin - *latest_ + period_ / 2) / period_;
    const Duration error = burst.begin - (*latest_ + periods * period_);
    const bool expected =
        periods >= 1 && absolute(error) <= std::max(2 * jitter_, kFirstJitter) + kFirstJitter;
    // One that is cut again and again shows that the rhythm is not this one.
    if (expected && (!burst.cut || deaf_ == 0)) {
        *latest_ += (periods - 1) * period_;
        keep_rhythm(burst.begin, error);
    } else if (expected || !burst.cut) {
        came_ = true;
        begin_rhythm(burst.begin);
    }
}

/// The rhythm is that of this burst and the one before.
void SamplingPlan::begin_rhythm(Instant begin) {
    const Duration interval = latest_ ? begin - *latest_ : Duration::zero();
    period_ = is_period(interval) ? interval : Duration::zero();
    jitter_ = kFirstJitter;
    missed_ = 0;
    latest_ = begin;
}

void SamplingPlan::lose_rhythm() {
    period_ = {};
    length_ = {};
    latest_.reset();
}

/// Three quarters of a burst's error are taken for one of the rhythm. All would be best if frames
/// jitter around the frame before, and less if around the sender's own clock.
void SamplingPlan::keep_rhythm(Instant begin, Duration error) {
    constexpr int kShareLeft = 4;
    constexpr int kShareOfPeriod = 16;
    came_ = true;
    latest_ = begin - error / kShareLeft;
    period_ += error / kShareOfPeriod;
    jitter_ = std::max(absolute(error), jitter_ - jitter_ / kJitterDecay);
    missed_ = 0;
    if (!is_period(period_)) {
        lose_rhythm();
    }
}

void SamplingPlan::ended(Instant end) {
    const bool came = std::exchange(came_, false);
    deaf_ = std::exchange(whole_, false) ? 0 : deaf_ + 1;
    if (deaf_ > kMostDeaf) {
        lose_rhythm();
    }
    const bool missed = follows() && !came && *latest_ + (missed_ + 1) * period_ < end;
    if (missed && ++missed_ > kMostMissed) {
        lose_rhythm();
    }
}

}  // namespace tribus
