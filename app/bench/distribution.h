#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/time.h"

namespace tribus::bench {

/// Measured times, sorted. Pure.
class Distribution {
  public:
    Distribution() = default;
    explicit Distribution(std::vector<Duration> samples);

    bool empty() const { return sorted_.empty(); }
    std::size_t size() const { return sorted_.size(); }
    std::span<const Duration> sorted() const { return sorted_; }
    /// The smallest sample that is at least as large as `percent` of all (nearest rank); 100 gives
    /// the largest. Zero without samples.
    Duration percentile(double percent) const;

  private:
    std::vector<Duration> sorted_;
};

/// `a` divided by `b`; zero if `b` is zero.
double ratio_of(Duration a, Duration b);

/// Factor by which noise of the machine may exceed a bound, from an anchor that was measured twice:
/// A2/A1, at least 1.
double noise_allowance(Duration anchor_1, Duration anchor_2);

/// The median: for an even number, the mean of the two middle values; zero without values.
double median_of(std::vector<double> values);

}  // namespace tribus::bench
