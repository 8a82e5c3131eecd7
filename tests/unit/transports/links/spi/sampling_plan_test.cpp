#include "transports/links/spi/sampling_plan.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

/// A port takes samples when the plan says so, and a sender sends SBUS.
namespace tribus::test::sampling_plan_test {
namespace {

using namespace std::chrono_literals;
using std::chrono::microseconds;

constexpr Instant kStart{100s};
constexpr Duration kLongest = 40ms;
/// 25 bytes of 12 bits of 10 us.
constexpr Duration kFrame = 3ms;
/// Without rest for so long in front of it, a burst is not found.
constexpr Duration kByte = 120us;
constexpr Duration kRest = kByte;

/// A sender, and what became of its frames.
class Sampling {
  public:
    /// `period`: when the next frame begins after that one.
    explicit Sampling(std::function<Duration()> period, Instant first = kStart + 1234us)
        : period_(std::move(period)), next_(first) {}

    /// Lets the port sample until then.
    void run(Instant until) {
        while (now_ < until) {
            sample();
        }
    }
    void change_period(std::function<Duration()> period) { period_ = std::move(period); }
    /// The next frame comes so much later.
    void pause(Duration by) { next_ += by; }
    /// No block is taken for that time.
    void be_away(Duration time) { now_ += time; }
    /// When the next frame begins.
    Instant next() const { return next_; }
    void forget() {
        sent = 0;
        received = 0;
        most_age = {};
    }

    int sent = 0;
    int received = 0;
    Duration most_age{};  ///< of a received frame's end when its block ended
    SamplingPlan plan{kLongest};

  private:
    void sample() {
        const Duration length = plan.next(now_);
        EXPECT_LE(length, kLongest);
        EXPECT_GT(length, Duration::zero());
        // A block needs some time beside its samples.
        const Instant begin = now_ + 60us + random_() % 60 * 1us;
        const Instant end = begin + length;
        while (next_ + kFrame < begin) {
            skip();
        }
        while (next_ < end) {
            if (hear(next_, kFrame, begin, end)) {
                ++received;
                most_age = std::max(most_age, end - (next_ + kFrame));
            }
            skip();
        }
        plan.ended(end);
        now_ = end + 40us;
    }
    /// Tells the plan of a burst as far as the block has it. Returns whether it has all of it.
    bool hear(Instant burst, Duration length, Instant begin, Instant end) {
        if (burst < begin + kRest || burst > end - kByte) {
            return false;
        }
        // A further byte might follow.
        const bool cut = burst + length > end - kByte;
        plan.found({.begin = burst, .end = std::min(burst + length, end), .cut = cut});
        return burst + length <= end;
    }
    void skip() {
        ++sent;
        next_ += period_();
    }

    std::function<Duration()> period_;
    std::mt19937 random_{7};
    Instant now_ = kStart;
    Instant next_;
};

std::function<Duration()> steady(Duration period) {
    return [period] { return period; };
}

/// Each frame comes up to `jitter` early or late, of the frame before or of the sender's clock.
std::function<Duration()> jittering(Duration period, Duration jitter, bool of_clock,
                                    unsigned seed = 1) {
    return [=, random = std::mt19937(seed), before = Duration::zero()]() mutable {
        std::uniform_int_distribution<std::int64_t> offset(-jitter.count(), jitter.count());
        const Duration by(offset(random));
        const Duration last = of_clock ? std::exchange(before, by) : Duration::zero();
        return period + by - last;
    };
}

class SamplingPlanOfARate : public testing::TestWithParam<int> {
  protected:
    Duration period() const { return std::chrono::milliseconds(GetParam()); }
};

/// From any phase: the first block may begin within a frame and end within another one.
TEST_P(SamplingPlanOfARate, FindsASenderWithin100Milliseconds) {
    for (Duration phase{}; phase < period(); phase += 50us) {
        Sampling sampling(steady(period()), kStart + phase);
        sampling.run(kStart + 100ms);
        EXPECT_TRUE(sampling.plan.follows());
        sampling.forget();
        sampling.run(kStart + 300ms);
        EXPECT_LE(sampling.sent - sampling.received, 1);
    }
}

/// To each other rate, at any time.
TEST_P(SamplingPlanOfARate, FindsASenderThatChangesItsRateWithin100Milliseconds) {
    for (const Duration other : {7ms, 9ms, 10ms, 14ms, 15ms, 18ms}) {
        for (Duration phase{}; phase < period(); phase += 500us) {
            Sampling sampling(steady(period()), kStart + phase);
            sampling.run(kStart + 1s);
            sampling.change_period(steady(other));
            sampling.run(kStart + 1100ms);
            sampling.forget();
            sampling.run(kStart + 2s);
            EXPECT_LE(sampling.sent - sampling.received, 1) << "to " << other.count() << " ns";
        }
    }
}

TEST_P(SamplingPlanOfARate, FindsASenderThatStoppedForAnyTimeWithin100Milliseconds) {
    for (Duration pause = 20ms; pause < 200ms; pause += 700us) {
        Sampling sampling(steady(period()));
        sampling.run(kStart + 1s);
        sampling.pause(pause);
        sampling.run(sampling.next() + 100ms);
        sampling.forget();
        sampling.run(kStart + 2s);
        EXPECT_LE(sampling.sent - sampling.received, 1) << pause.count() << " ns";
    }
}

TEST_P(SamplingPlanOfARate, LosesNothingElseIfTheSenderLeavesAFrameOut) {
    Sampling sampling(steady(period()));
    sampling.run(kStart + 1s);
    sampling.forget();
    for (int i = 0; i < 100; ++i) {
        sampling.pause(period());
        sampling.run(sampling.next() + 10 * period());
    }
    EXPECT_LE(sampling.sent - sampling.received, 1);
}

TEST_P(SamplingPlanOfARate, LosesNothingOfASteadySender) {
    Sampling sampling(steady(period()));
    sampling.run(kStart + 200ms);
    sampling.forget();
    sampling.run(kStart + 20'000 * period());
    EXPECT_GT(sampling.sent, 19'000);
    EXPECT_LE(sampling.sent - sampling.received, 1);
}

TEST_P(SamplingPlanOfARate, IsSoonThereWithASteadySendersFrames) {
    Sampling sampling(steady(period()));
    sampling.run(kStart + 30s);
    sampling.forget();
    sampling.run(kStart + 40s);
    EXPECT_LE(sampling.most_age, 500us);
}

TEST_P(SamplingPlanOfARate, LosesOneOf200FramesAtMostIfTheSenderJittersByAMillisecond) {
    for (const bool of_clock : {false, true}) {
        Sampling sampling(jittering(period(), 1ms, of_clock));
        sampling.run(kStart + 200ms);
        sampling.forget();
        sampling.run(kStart + 10'000 * period());
        EXPECT_LE((sampling.sent - sampling.received) * 200, sampling.sent)
            << sampling.sent - sampling.received << " of " << sampling.sent
            << (of_clock ? " around its clock" : " after the frame before");
    }
}

/// Blocks that a busy machine held up tell nothing, and measuring the port takes its time.
TEST_P(SamplingPlanOfARate, FindsASenderAgainAfterATimeWithoutBlocks) {
    for (Duration phase{}; phase < period(); phase += 100us) {
        Sampling sampling(steady(period()));
        sampling.run(kStart + 1s);
        sampling.be_away(300ms + phase);
        sampling.pause(phase * 2);
        sampling.run(kStart + 1500ms);
        sampling.forget();
        sampling.run(kStart + 3s);
        EXPECT_LE(sampling.sent - sampling.received, 1);
    }
}

INSTANTIATE_TEST_SUITE_P(Rates, SamplingPlanOfARate, testing::Values(7, 9, 10, 14, 15, 18));

}  // namespace
}  // namespace tribus::test::sampling_plan_test
