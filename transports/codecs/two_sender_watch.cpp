#include "transports/codecs/two_sender_watch.h"

#include <algorithm>

namespace tribus {
namespace {

/// Share of its period within which a sender is exact.
constexpr int kExactness = 50;
/// Percentage of arrivals that must come one period after another one.
constexpr std::size_t kLeastAtPeriod = 30;
/// Percentage of arrivals that must do so with an arrival of another sender in between.
constexpr std::size_t kLeastSeparated = 8;
/// Number of latest arrivals whose distances are tried as periods.
constexpr std::size_t kPeriodsTried = 8;

bool near(Duration a, Duration b, Duration tolerance) {
    return std::chrono::abs(a - b) <= tolerance;
}

/// Whether the two gaps look like a single sender that is late or loses frames.
bool like_one_sender(Duration gap, Duration other) {
    const Duration whole = gap + other;
    const auto [small, large] = std::minmax(gap, other);
    return small * 20 > whole * 7 || near(large, small * 2, whole / 12) ||
           near(large, small * 3, whole / 12);
}

}  // namespace

void TwoSenderWatch::arrived(Instant at) {
    arrivals_[count_++] = at;
    if (count_ == kJudgedArrivals) {
        two_senders_ = two_senders_ || judge();
        count_ = 0;
    }
}

bool TwoSenderWatch::judge() const {
    for (std::size_t i = kJudgedArrivals - kPeriodsTried; i < kJudgedArrivals; ++i) {
        if (two_with_period(gap(i)) || two_with_period(gap(i) + gap(i - 1))) {
            return true;
        }
    }
    return false;
}

bool TwoSenderWatch::two_with_period(Duration period) const {
    const Duration tolerance = period / kExactness;
    std::size_t plain = 0;
    std::size_t separated = 0;
    for (std::size_t i = 2; i < kJudgedArrivals; ++i) {
        if (near(gap(i), period, tolerance)) {
            ++plain;
        } else if (near(gap(i) + gap(i - 1), period, tolerance) &&
                   !like_one_sender(gap(i), gap(i - 1))) {
            ++separated;
        }
    }
    return (plain + separated) * 100 >= kJudgedArrivals * kLeastAtPeriod &&
           separated * 100 >= kJudgedArrivals * kLeastSeparated;
}

}  // namespace tribus
