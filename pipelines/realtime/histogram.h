#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/time.h"

namespace tribus {

/// Number of buckets: 256 ns wide up to 1 us, then four for each power of two, so a bucket is at
/// most a quarter wider than its start. The last one takes everything from about 0.5 s on. A
/// negative duration counts as zero.
inline constexpr std::size_t kHistogramBuckets = 80;
std::size_t histogram_bucket(Duration value);
/// Start of a bucket. For `kHistogramBuckets`: end of the last one.
Duration histogram_bucket_start(std::size_t bucket);

/// Content of a histogram when it was read.
struct HistogramReading {
    std::array<std::uint64_t, kHistogramBuckets> counts{};
    Duration worst{};

    std::uint64_t count() const;
    /// The value below which `share` (0 to 1) of all values lie, interpolated within the bucket and
    /// at most the worst value. Zero if there are no values.
    Duration quantile(double share) const;
};

/// Counts durations since its construction and over the last minute, in fixed memory. One thread
/// records, without a lock or a read-modify-write. Any thread may read meanwhile, but may see some
/// values earlier than others. No allocation.
class Histogram {
  public:
    /// `now` is when the value was measured. It never decreases.
    void record(Duration value, Instant now);

    HistogramReading since_start() const;
    /// Values of the last 30 to 60 seconds before `now`.
    HistogramReading last_minute(Instant now) const;

  private:
    static constexpr Duration kWindow = std::chrono::seconds(30);

    /// Half a minute. A full bucket stays full (2,184 values per second would fill it); what comes
    /// then is counted in `earlier_`.
    struct Window {
        std::array<std::atomic<std::uint16_t>, kHistogramBuckets> counts{};
        std::atomic<std::int64_t> worst_ns{0};
    };
    void retire(Window& window);
    static void add(const Window& window, HistogramReading& to);
    HistogramReading all() const;
    void turn_windows(Instant now);

    /// Values that are in no window any more.
    std::array<std::atomic<std::uint32_t>, kHistogramBuckets> earlier_{};
    std::atomic<std::int64_t> earlier_worst_ns_{0};
    /// Odd while values move from a window to `earlier_`.
    std::atomic<std::uint32_t> turns_{0};
    std::array<Window, 2> windows_{};
    std::atomic<std::size_t> current_{0};
    std::atomic<std::int64_t> window_end_ns_{0};
};

}  // namespace tribus
