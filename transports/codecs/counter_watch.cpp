#include "transports/codecs/counter_watch.h"

#include <algorithm>

namespace tribus {
namespace {

/// Least time of one count: no sender of channels is faster. Frames from a queue can be.
constexpr Duration kLeastPace = std::chrono::milliseconds(2);
/// Share of the pace by which one count changes the estimate.
constexpr int kPaceShare = 8;
/// At least 5/8 of the time of the counts must have passed, because arrivals jitter.
constexpr int kTimeNeeded = 5;
constexpr int kTimeOf = 8;

}  // namespace

void CounterWatch::require_long_proof() {
    // A queue that empties after an outage also ends in a jump, but its frames were never accepted.
    if (due_ > 0 || proof_ >= std::max(limits_.proof, 1U)) {
        const std::uint64_t ring = std::min(limits_.values, kLongestRing);
        due_ = std::max({due_, ring, run_ < kRemembered ? run_ + 1 : 0});
    }
    run_ = 0;
    restart_proof();
}

CounterWatch::Verdict CounterWatch::begin() {
    restart_proof();
    run_ = kRemembered;
    pace_ = spare_ = Duration::zero();
    return limits_.proof == 0 && due_ == 0 ? Verdict::good : Verdict::unconfirmed;
}

bool CounterWatch::time_allows(std::uint64_t step, Duration elapsed) const {
    if (step == 1) {
        return true;
    }
    if (pace_ == Duration::zero()) {
        return step <= limits_.most_step;
    }
    return static_cast<std::uint64_t>((elapsed + spare_) * kTimeOf / (pace_ * kTimeNeeded)) >= step;
}

void CounterWatch::learn_pace(std::uint64_t step, Duration elapsed) {
    spare_ = pace_ == Duration::zero()
                 ? Duration::zero()
                 : std::max(elapsed - pace_ * static_cast<std::int64_t>(step), Duration::zero());
    if (step != 1 || elapsed == Duration::zero()) {
        return;
    }
    const Duration sample = std::max(elapsed, kLeastPace);
    pace_ = pace_ == Duration::zero() ? sample
                                      : pace_ + (std::min(sample, pace_ * 2) - pace_) / kPaceShare;
}

CounterWatch::Verdict CounterWatch::advance(std::uint64_t step) {
    proof_ = std::min(proof_ + 1, std::max(limits_.proof, 1U));
    run_ = std::min(run_ + step, kRemembered);
    due_ -= std::min(due_, step);
    return proof_ >= limits_.proof && due_ == 0 ? Verdict::good : Verdict::unconfirmed;
}

CounterWatch::Verdict CounterWatch::take(std::uint64_t count, bool same_content, Instant received) {
    // A receiver's time stamps may also run backwards a little.
    const Duration elapsed = std::max(received - received_, Duration::zero());
    const auto previous = elapsed > limits_.silence ? std::nullopt : count_;
    count_ = count < limits_.values ? std::optional(count) : std::nullopt;
    received_ = received;
    if (!count_) {
        restart_proof();
        return Verdict::jump;
    }
    if (!previous) {
        return begin();
    }
    const std::uint64_t step = (count + limits_.values - *previous) % limits_.values;
    if (step == 0 && same_content) {
        // The same frame may come twice after an error that only its sender saw.
        spare_ = std::min(spare_ + elapsed, limits_.silence);
        return Verdict::repeated;
    }
    if (step == 0) {
        require_long_proof();
        return Verdict::conflict;
    }
    if (!time_allows(step, elapsed)) {
        spare_ = Duration::zero();
        require_long_proof();
        return Verdict::jump;
    }
    learn_pace(step, elapsed);
    if (step > limits_.most_step) {
        restart_proof();
        return Verdict::jump;
    }
    return advance(step);
}

}  // namespace tribus
