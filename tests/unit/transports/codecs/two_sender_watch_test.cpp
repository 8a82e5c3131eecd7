#include "transports/codecs/two_sender_watch.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"

namespace tribus::rhythm_watch_test::two_sender_watch_test {
namespace {

using namespace std::chrono_literals;

/// Arrival times from a sender, each late by up to `jitter`. A share of the frames is lost.
struct Sender {
    Duration period{};
    Duration first{};
    Duration jitter{};
    unsigned lost_percent = 0;
};

bool two_seen(const std::vector<Sender>& senders, std::uint32_t seed = 1) {
    test::Random random(seed);
    std::vector<Instant> arrivals;
    for (const Sender& sender : senders) {
        for (Duration at = sender.first; at < 10s; at += sender.period) {
            const auto late = Duration(sender.jitter.count() * random.below(1001) / 1000);
            if (random.below(100) >= sender.lost_percent) {
                arrivals.emplace_back(at + late);
            }
        }
    }
    std::ranges::sort(arrivals);
    TwoSenderWatch watch;
    for (const Instant at : arrivals) {
        watch.arrived(at);
    }
    return watch.two_senders();
}

TEST(TwoSenderWatch, SeesASecondSenderThatIsRarer) {
    EXPECT_TRUE(two_seen({{20ms}, {100ms, 16ms}}));
    EXPECT_TRUE(two_seen({{10ms, 0ms, 100us}, {40ms, 2ms, 100us}}));
}

TEST(TwoSenderWatch, SeesASecondSenderOfNearlyTheSameRate) {
    EXPECT_TRUE(two_seen({{20ms}, {23ms, 5ms}}));
    EXPECT_TRUE(two_seen({{20ms, 0ms, 200us}, {20ms, 4ms, 200us}}));
}

TEST(TwoSenderWatch, TakesNoSingleSenderForTwoHoweverItJittersAndLoses) {
    for (const Duration period : {2ms, 10ms, 20ms, 100ms}) {
        for (const int jitter_percent : {0, 1, 2, 5, 10, 20, 50, 100}) {
            for (const unsigned lost : {0U, 1U, 10U, 30U, 50U}) {
                const Duration jitter = period * jitter_percent / 100;
                EXPECT_FALSE(two_seen({{period, 0ms, jitter, lost}},
                                      static_cast<std::uint32_t>(jitter_percent + 1)))
                    << period / 1ms << " ms, jitter " << jitter_percent << " %, lost " << lost
                    << " %";
            }
        }
    }
}

TEST(TwoSenderWatch, SaysNothingBeforeEnoughArrivals) {
    TwoSenderWatch watch;
    for (int i = 0; i < 31; ++i) {
        watch.arrived(Instant(i * 20ms));
        watch.arrived(Instant(i * 20ms + 4ms));
    }
    EXPECT_FALSE(watch.two_senders());
}

TEST(TwoSenderWatch, RemembersWhatItSaw) {
    TwoSenderWatch watch;
    for (int i = 0; i < 32; ++i) {
        watch.arrived(Instant(i * 20ms));
        watch.arrived(Instant(i * 20ms + 4ms));
    }
    EXPECT_TRUE(watch.two_senders());
    for (int i = 0; i < 640; ++i) {
        watch.arrived(Instant(1s + i * 20ms));
    }
    EXPECT_TRUE(watch.two_senders());
}

}  // namespace
}  // namespace tribus::rhythm_watch_test::two_sender_watch_test
