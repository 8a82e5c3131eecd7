#include "transports/links/spi/spi_clock_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tribus {
namespace {

double ns_of(Duration duration) {
    return static_cast<double>(duration.count());
}

}  // namespace

void SpiClockWatch::transferred(std::size_t bytes, Duration took) {
    if (suspects_ || bytes == 0) {
        return;
    }
    constexpr double kSuspicious = 0.0125;
    const double share = ns_of(took - call_) / (static_cast<double>(bytes) * ns_of(byte_time_)) - 1;
    least_ = seen_ == 0 ? share : std::min(least_, share);
    if (++seen_ == kWindow) {
        seen_ = 0;
        suspects_ = std::abs(least_) > kSuspicious;
    }
}

std::size_t SpiClockWatch::wanted_zeros() const {
    return suspects_ ? kLengths.at(static_cast<std::size_t>(compared_) % kLengths.size()) : 0;
}

bool SpiClockWatch::compared(Duration took) {
    Duration& shortest = shortest_.at(static_cast<std::size_t>(compared_) % shortest_.size());
    shortest = std::min(shortest, took);
    if (++compared_ < kComparisons) {
        return false;
    }
    const auto bytes = static_cast<double>(kLengths[1] - kLengths[0]);
    const double drift = ns_of(shortest_[1] - shortest_[0]) / (bytes * ns_of(byte_time_)) - 1;
    // Both lengths say what a call takes, whatever a byte does now.
    call_ = shortest_[0] - (shortest_[1] - shortest_[0]) * static_cast<std::int64_t>(kLengths[0]) /
                               static_cast<std::int64_t>(kLengths[1] - kLengths[0]);
    compared_ = 0;
    shortest_ = {Duration::max(), Duration::max()};
    suspects_ = false;
    return std::abs(drift) > kMostDrift;
}

}  // namespace tribus
