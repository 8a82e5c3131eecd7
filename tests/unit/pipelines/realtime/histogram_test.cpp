#include "pipelines/realtime/histogram.h"

#include <cstdint>

#include <gtest/gtest.h>

namespace tribus::histogram_test {
namespace {

using namespace std::chrono_literals;

Instant at(Duration since_start) {
    return Instant(since_start);
}

Histogram& record_each_microsecond(Histogram& histogram, int from, int to) {
    for (int us = from; us < to; ++us) {
        histogram.record(std::chrono::microseconds(us), at(1s));
    }
    return histogram;
}

TEST(HistogramBuckets, EveryStartIsInItsOwnBucketAndWhatIsBeforeItInTheOneBefore) {
    for (std::size_t bucket = 1; bucket < kHistogramBuckets; ++bucket) {
        const Duration start = histogram_bucket_start(bucket);
        EXPECT_EQ(histogram_bucket(start), bucket);
        EXPECT_EQ(histogram_bucket(start - 1ns), bucket - 1);
    }
}

TEST(HistogramBuckets, FromAMicrosecondOnNoBucketIsWiderThanAQuarterOfItsStart) {
    for (std::size_t bucket = 4; bucket < kHistogramBuckets; ++bucket) {
        const Duration start = histogram_bucket_start(bucket);
        EXPECT_LE(histogram_bucket_start(bucket + 1) - start, start / 4);
    }
}

TEST(HistogramBuckets, WhatIsBeyondTheRangeCountsAtItsEnds) {
    EXPECT_EQ(histogram_bucket(-1s), 0U);
    EXPECT_EQ(histogram_bucket(24h), kHistogramBuckets - 1);
    EXPECT_EQ(histogram_bucket(Duration::max()), kHistogramBuckets - 1);
}

TEST(Histogram, AnEmptyOneHasNoCountAndQuantilesOfZero) {
    const Histogram histogram;
    EXPECT_EQ(histogram.since_start().count(), 0U);
    EXPECT_EQ(histogram.since_start().quantile(0.99), 0ns);
}

TEST(Histogram, QuantilesAreRightToABucket) {
    Histogram histogram;
    const HistogramReading all = record_each_microsecond(histogram, 0, 10'000).since_start();
    EXPECT_EQ(all.count(), 10'000U);
    for (const double share : {0.5, 0.9, 0.99}) {
        const Duration right{static_cast<std::int64_t>(share * 1e7)};
        EXPECT_EQ(histogram_bucket(all.quantile(share)), histogram_bucket(right)) << share;
    }
}

TEST(Histogram, NoQuantileIsAboveTheWorstValueWhichIsKeptExactly) {
    Histogram histogram;
    histogram.record(1234567ns, at(0s));
    EXPECT_EQ(histogram.since_start().worst, 1234567ns);
    EXPECT_EQ(histogram.since_start().quantile(1.0), 1234567ns);
}

TEST(Histogram, TheLastMinuteForgetsWhatIsOlderAndTheStartDoesNot) {
    Histogram histogram;
    histogram.record(5ms, at(0s));
    histogram.record(1ms, at(45s));
    EXPECT_EQ(histogram.last_minute(at(45s)).count(), 2U);
    histogram.record(1ms, at(80s));
    EXPECT_EQ(histogram.last_minute(at(80s)).count(), 2U);
    EXPECT_EQ(histogram.last_minute(at(80s)).worst, 1ms);
    EXPECT_EQ(histogram.since_start().count(), 3U);
    EXPECT_EQ(histogram.since_start().worst, 5ms);
}

TEST(Histogram, TheLastMinuteForgetsAlsoWhileNothingIsRecorded) {
    Histogram histogram;
    histogram.record(5ms, at(100s));
    EXPECT_EQ(histogram.last_minute(at(129s)).count(), 1U);
    EXPECT_EQ(histogram.last_minute(at(200s)).count(), 0U);
}

TEST(Histogram, TheLastMinuteNeverCoversLessThanHalfOfOneNorMoreThanOne) {
    for (Duration age = 0s; age <= 61s; age += 100ms) {
        for (Duration offset = 0s; offset < 30s; offset += 7300ms) {
            Histogram histogram;
            // Values every 100 ms before, so that the windows change as they do in use.
            for (Instant now = at(10s); now < at(100s) + offset; now += 100ms) {
                histogram.record(1ms, now);
            }
            histogram.record(5ms, at(100s) + offset);
            for (Duration later = 100ms; later <= age; later += 100ms) {
                histogram.record(1ms, at(100s) + offset + later);
            }
            const HistogramReading minute = histogram.last_minute(at(100s) + offset + age);
            const bool seen = minute.worst == 5ms;
            EXPECT_TRUE(seen || age >= 30s) << age.count() << " " << offset.count();
            EXPECT_FALSE(seen && age > 60s) << age.count() << " " << offset.count();
        }
    }
}

TEST(Histogram, ABucketOfTheLastMinuteThatIsFullStaysFull) {
    Histogram histogram;
    for (int i = 0; i < 70'000; ++i) {
        histogram.record(1ms, at(1s));
    }
    EXPECT_EQ(histogram.last_minute(at(1s)).count(), 65'535U);
    EXPECT_EQ(histogram.since_start().count(), 70'000U);
}

}  // namespace
}  // namespace tribus::histogram_test
