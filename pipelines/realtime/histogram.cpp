#include "pipelines/realtime/histogram.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

namespace tribus {
namespace {

constexpr unsigned kUnitShift = 8;  // the finest bucket: 256 ns
constexpr unsigned kSubBucketShift = 2;
constexpr std::uint64_t kSubBuckets = 1U << kSubBucketShift;

/// Increments up to the maximum. Only one thread writes, so no increment is lost.
template <class Count>
void bump(std::atomic<Count>& count) {
    const Count before = count.load(std::memory_order_relaxed);
    if (before < std::numeric_limits<Count>::max()) {
        count.store(static_cast<Count>(before + 1), std::memory_order_relaxed);
    }
}

void raise(std::atomic<std::int64_t>& worst, std::int64_t value) {
    if (value > worst.load(std::memory_order_relaxed)) {
        worst.store(value, std::memory_order_relaxed);
    }
}

}  // namespace

std::size_t histogram_bucket(Duration value) {
    const auto units =
        static_cast<std::uint64_t>(std::max<std::int64_t>(value.count(), 0)) >> kUnitShift;
    if (units < kSubBuckets) {
        return static_cast<std::size_t>(units);
    }
    const auto octave = static_cast<unsigned>(std::bit_width(units)) - (kSubBucketShift + 1);
    const std::uint64_t bucket = octave * kSubBuckets + (units >> octave);
    return static_cast<std::size_t>(std::min<std::uint64_t>(bucket, kHistogramBuckets - 1));
}

Duration histogram_bucket_start(std::size_t bucket) {
    std::uint64_t units = bucket;
    if (bucket >= kSubBuckets) {
        const std::uint64_t octave = bucket / kSubBuckets - 1;
        units = (bucket % kSubBuckets + kSubBuckets) << octave;
    }
    return Duration(static_cast<std::int64_t>(units << kUnitShift));
}

std::uint64_t HistogramReading::count() const {
    return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

Duration HistogramReading::quantile(double share) const {
    const double wanted = share * static_cast<double>(count());
    double below = 0;
    for (std::size_t bucket = 0; bucket < counts.size(); ++bucket) {
        const auto here = static_cast<double>(counts[bucket]);
        if (here > 0 && below + here >= wanted) {
            const Duration start = histogram_bucket_start(bucket);
            const Duration width = histogram_bucket_start(bucket + 1) - start;
            const double part = (wanted - below) / here * static_cast<double>(width.count());
            return std::min(start + Duration(static_cast<std::int64_t>(part)), worst);
        }
        below += here;
    }
    return worst;
}

void Histogram::clear(Window& window) {
    for (auto& count : window.counts) {
        count.store(0, std::memory_order_relaxed);
    }
    window.worst_ns.store(0, std::memory_order_relaxed);
}

void Histogram::add(const Window& window, HistogramReading& to) {
    for (std::size_t bucket = 0; bucket < kHistogramBuckets; ++bucket) {
        to.counts[bucket] += window.counts[bucket].load(std::memory_order_relaxed);
    }
    to.worst = std::max(to.worst, Duration(window.worst_ns.load(std::memory_order_relaxed)));
}

/// The older half minute is replaced by a new one; after a long silence both are.
void Histogram::turn_windows(Instant now) {
    const std::size_t older = 1 - current_.load(std::memory_order_relaxed);
    const Instant end{Duration(window_end_ns_.load(std::memory_order_relaxed))};
    clear(windows_[older]);
    if (now >= end + kWindow) {
        clear(windows_[1 - older]);
    }
    current_.store(older, std::memory_order_relaxed);
    window_end_ns_.store((now + kWindow).time_since_epoch().count(), std::memory_order_relaxed);
}

void Histogram::record(Duration value, Instant now) {
    if (now.time_since_epoch().count() >= window_end_ns_.load(std::memory_order_relaxed)) {
        turn_windows(now);
    }
    const std::size_t bucket = histogram_bucket(value);
    Window& window = windows_[current_.load(std::memory_order_relaxed)];
    bump(counts_[bucket]);
    bump(window.counts[bucket]);
    raise(worst_ns_, value.count());
    raise(window.worst_ns, value.count());
}

HistogramReading Histogram::since_start() const {
    HistogramReading reading;
    for (std::size_t bucket = 0; bucket < kHistogramBuckets; ++bucket) {
        reading.counts[bucket] = counts_[bucket].load(std::memory_order_relaxed);
    }
    reading.worst = Duration(worst_ns_.load(std::memory_order_relaxed));
    return reading;
}

HistogramReading Histogram::last_minute(Instant now) const {
    HistogramReading reading;
    const std::size_t current = current_.load(std::memory_order_relaxed);
    const Instant end{Duration(window_end_ns_.load(std::memory_order_relaxed))};
    if (now < end + kWindow) {
        add(windows_[current], reading);
    }
    if (now < end) {
        add(windows_[1 - current], reading);
    }
    return reading;
}

}  // namespace tribus
