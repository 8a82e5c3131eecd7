#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/time.h"

namespace tribus::bench {

/// Measured times, smallest first. Pure.
class Distribution {
  public:
    Distribution() = default;
    explicit Distribution(std::vector<Duration> samples);

    bool empty() const { return sorted_.empty(); }
    std::size_t size() const { return sorted_.size(); }
    std::span<const Duration> sorted() const { return sorted_; }
    /// The smallest sample that is at least as large as `percent` of all (nearest rank); 100 is the
    /// largest. Zero where there is none.
    Duration percentile(double percent) const;

  private:
    std::vector<Duration> sorted_;
};

/// `a` over `b`; zero where `b` is zero.
double ratio_of(Duration a, Duration b);

/// Of an anchor that was measured twice beside a candidate: what the machine's own noise allows on
/// top of a bound, A2/A1 and never less than 1.
double noise_allowance(Duration anchor_1, Duration anchor_2);

/// The middle one; the mean of the two middle ones of an even number; zero of none.
double median_of(std::vector<double> values);

}  // namespace tribus::bench
