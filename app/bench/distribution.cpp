#include "app/bench/distribution.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tribus::bench {

Distribution::Distribution(std::vector<Duration> samples) : sorted_(std::move(samples)) {
    std::sort(sorted_.begin(), sorted_.end());
}

Duration Distribution::percentile(double percent) const {
    if (sorted_.empty()) {
        return Duration::zero();
    }
    const double rank = std::ceil(percent / 100 * static_cast<double>(sorted_.size()));
    const auto last = static_cast<double>(sorted_.size());
    return sorted_[static_cast<std::size_t>(std::clamp(rank, 1.0, last)) - 1];
}

double ratio_of(Duration a, Duration b) {
    return b == Duration::zero() ? 0
                                 : static_cast<double>(a.count()) / static_cast<double>(b.count());
}

double noise_allowance(Duration anchor_1, Duration anchor_2) {
    return std::max(1.0, ratio_of(anchor_2, anchor_1));
}

double median_of(std::vector<double> values) {
    if (values.empty()) {
        return 0;
    }
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

}  // namespace tribus::bench
