#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/time.h"

namespace tribus {

/// Measured times, sorted. Pure.
class Distribution {
  public:
    Distribution() = default;
    explicit Distribution(std::vector<Duration> samples) : sorted_(std::move(samples)) {
        std::sort(sorted_.begin(), sorted_.end());
    }

    bool empty() const { return sorted_.empty(); }
    std::size_t size() const { return sorted_.size(); }
    /// The smallest sample that is at least as large as `percent` of all (nearest rank); 100 gives
    /// the largest. Zero without samples.
    Duration percentile(double percent) const {
        const double rank = std::ceil(percent / 100 * static_cast<double>(size()));
        const auto index = static_cast<std::size_t>(std::max(rank, 1.0)) - 1;
        return empty() ? Duration::zero() : sorted_[index];
    }

  private:
    std::vector<Duration> sorted_;
};

/// `a` divided by `b`; zero if `b` is zero.
inline double ratio_of(Duration a, Duration b) {
    return b == Duration::zero() ? 0 : std::chrono::duration<double>(a) / b;
}

/// Factor by which noise of the machine may exceed a bound, from an anchor that was measured twice:
/// A2/A1, at least 1.
inline double noise_allowance(Duration anchor_1, Duration anchor_2) {
    return std::max(1.0, ratio_of(anchor_2, anchor_1));
}

}  // namespace tribus
