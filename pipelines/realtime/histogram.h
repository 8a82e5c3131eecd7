#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/time.h"

namespace tribus {

/// Buckets of durations: 256 ns wide up to 1 us, then four to each power of two, so a bucket is at
/// most a quarter wider than what it starts with. The last one, from about 0.5 s, takes all above.
/// A negative duration counts as none.
inline constexpr std::size_t kHistogramBuckets = 80;
std::size_t histogram_bucket(Duration value);
/// Where a bucket starts; of `kHistogramBuckets`, where the last one ends.
Duration histogram_bucket_start(std::size_t bucket);

/// What a histogram held when it was read: a plain value.
struct HistogramReading {
    std::array<std::uint64_t, kHistogramBuckets> counts{};
    Duration worst{};

    std::uint64_t count() const;
    /// The value below which `share` (0 to 1) of all lie, straight within a bucket and never above
    /// the worst; zero where there are none.
    Duration quantile(double share) const;
};

/// Counts durations, since it was made and over the last minute, in fixed memory. One thread
/// records, without a lock or a read-modify-write; any thread may read meanwhile, and then sees
/// some values a moment before others. No allocation.
class Histogram {
  public:
    /// `now` is when it happened; it does not go back.
    void record(Duration value, Instant now);

    HistogramReading since_start() const;
    /// The last 30 to 60 seconds before `now`.
    HistogramReading last_minute(Instant now) const;

  private:
    static constexpr Duration kWindow = std::chrono::seconds(30);

    /// Half a minute; a bucket that is full stays full (2,184 values a second would fill it).
    struct Window {
        std::array<std::atomic<std::uint16_t>, kHistogramBuckets> counts{};
        std::atomic<std::int64_t> worst_ns{0};
    };
    static void clear(Window& window);
    static void add(const Window& window, HistogramReading& to);
    void turn_windows(Instant now);

    std::array<std::atomic<std::uint32_t>, kHistogramBuckets> counts_{};
    std::atomic<std::int64_t> worst_ns_{0};
    std::array<Window, 2> windows_{};
    std::atomic<std::size_t> current_{0};
    std::atomic<std::int64_t> window_end_ns_{0};
};

}  // namespace tribus
