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

/// Returns false if the count is at its maximum. Only one thread writes, so no increment is lost.
template <class Count>
bool bump(std::atomic<Count>& count, Count by = 1) {
    const Count before = count.load(std::memory_order_relaxed);
    if (before > std::numeric_limits<Count>::max() - by) {
        return false;
    }
    count.store(static_cast<Count>(before + by), std::memory_order_relaxed);
    return true;
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

/// Moves the values of a window to those before it.
void Histogram::retire(Window& window) {
    for (std::size_t bucket = 0; bucket < kHistogramBuckets; ++bucket) {
        const std::uint32_t count = window.counts[bucket].load(std::memory_order_relaxed);
        if (count > 0) {
            window.counts[bucket].store(0, std::memory_order_relaxed);
            bump(earlier_[bucket], count);
        }
    }
    raise(earlier_worst_ns_, window.worst_ns.load(std::memory_order_relaxed));
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
    const std::uint32_t turn = turns_.load(std::memory_order_relaxed);
    turns_.store(turn + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    retire(windows_[older]);
    if (now >= end + kWindow) {
        retire(windows_[1 - older]);
    }
    turns_.store(turn + 2, std::memory_order_release);
    current_.store(older, std::memory_order_relaxed);
    window_end_ns_.store((now + kWindow).time_since_epoch().count(), std::memory_order_relaxed);
}

void Histogram::record(Duration value, Instant now) {
    if (now.time_since_epoch().count() >= window_end_ns_.load(std::memory_order_relaxed)) {
        turn_windows(now);
    }
    const std::size_t bucket = histogram_bucket(value);
    Window& window = windows_[current_.load(std::memory_order_relaxed)];
    if (!bump(window.counts[bucket])) {
        bump(earlier_[bucket]);
    }
    raise(window.worst_ns, value.count());
}

HistogramReading Histogram::all() const {
    HistogramReading reading;
    for (std::size_t bucket = 0; bucket < kHistogramBuckets; ++bucket) {
        reading.counts[bucket] = earlier_[bucket].load(std::memory_order_relaxed);
    }
    reading.worst = Duration(earlier_worst_ns_.load(std::memory_order_relaxed));
    for (const Window& window : windows_) {
        add(window, reading);
    }
    return reading;
}

/// Reads again if values moved meanwhile, which takes a microsecond every half minute.
HistogramReading Histogram::since_start() const {
    constexpr int kTries = 100;
    HistogramReading reading;
    for (int tries = 0; tries < kTries; ++tries) {
        const std::uint32_t before = turns_.load(std::memory_order_acquire);
        reading = all();
        std::atomic_thread_fence(std::memory_order_acquire);
        if (before % 2 == 0 && turns_.load(std::memory_order_relaxed) == before) {
            break;
        }
    }
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
