#include "transports/links/link_worker.h"

#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <semaphore>
#include <thread>

#include <gtest/gtest.h>

#include "pipelines/realtime/clock.h"
#include "tests/support/seen_within.h"

namespace tribus::test::link_worker_test {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPeriod = 20ms;

/// The life of a frame that was made now, with a period of 20 ms.
FrameLife fresh() {
    return {.made = monotonic_now(), .valid_for = kPeriod};
}

/// As of an output with a long period.
FrameLife long_lived() {
    return {.made = monotonic_now(), .valid_for = 10s};
}

/// A kernel that keeps its writer until it is let go.
struct SlowKernel {
    std::counting_semaphore<> let_go{0};
    std::atomic<int> begun = 0;

    void take() {
        ++begun;
        let_go.acquire();
    }
    void start(LinkWorker& worker) {
        ASSERT_EQ(worker.start({.now = monotonic_now},
                               [this] {
                                   take();
                                   return WriteStatus::written;
                               }),
                  "");
    }
};

TEST(LinkWorker, WorksOnceForAllThatCameMeanwhile) {
    SlowKernel kernel;
    LinkWorker worker;
    kernel.start(worker);
    EXPECT_EQ(worker.wake(fresh()), WriteStatus::written);
    ASSERT_TRUE(seen_within([&] { return kernel.begun == 1; }));
    for (int i = 0; i < 5; ++i) {
        worker.wake(fresh());
    }
    kernel.let_go.release(2);
    EXPECT_TRUE(seen_within([&] { return kernel.begun == 2; }));
    std::this_thread::sleep_for(50ms);
    EXPECT_EQ(kernel.begun, 2);
}

TEST(LinkWorker, IsUnavailableWhileTheKernelKeepsItAndOnlyThen) {
    SlowKernel kernel;
    LinkWorker worker;
    kernel.start(worker);
    worker.wake(long_lived());
    EXPECT_TRUE(seen_within([&] { return worker.wake(long_lived()) == WriteStatus::unavailable; }));
    EXPECT_EQ(worker.wake(long_lived()), WriteStatus::unavailable) << "it is not forgotten";
    kernel.let_go.release(1000);
    EXPECT_TRUE(seen_within([&] { return worker.wake(long_lived()) == WriteStatus::written; }));
    // Idle for longer than any part of the work may take. A busy machine may keep the thread in its
    // work for as long, but not each time.
    EXPECT_TRUE(seen_within([&] {
        std::this_thread::sleep_for(300ms);
        return worker.wake(long_lived()) == WriteStatus::written;
    }));
}

TEST(LinkWorker, TellsTheOutcomeOfTheWorkThatWasDoneLast) {
    std::atomic<WriteStatus> outcome = WriteStatus::lost;
    LinkWorker worker;
    ASSERT_EQ(worker.start({.now = monotonic_now}, [&] { return outcome.load(); }), "");
    EXPECT_TRUE(seen_within([&] { return worker.wake(fresh()) == WriteStatus::lost; }));
    outcome = WriteStatus::written;
    EXPECT_TRUE(seen_within([&] { return worker.wake(fresh()) == WriteStatus::written; }));
}

TEST(LinkWorker, TellsAPartThatFailedBeforeTheWorkIsDone) {
    SlowKernel kernel;
    LinkWorker worker;
    ASSERT_EQ(worker.start({.now = monotonic_now},
                           [&] {
                               worker.part_done(WriteStatus::lost);
                               kernel.take();
                               return WriteStatus::written;
                           }),
              "");
    worker.wake(fresh());
    EXPECT_TRUE(seen_within([&] { return worker.wake(fresh()) == WriteStatus::lost; }));
    kernel.let_go.release(1000);
}

TEST(LinkWorker, MayTakeLongForManyPartsThatAreShort) {
    std::atomic<bool> ends = false;
    LinkWorker worker;
    ASSERT_EQ(worker.start({.now = monotonic_now},
                           [&] {
                               while (!ends) {
                                   worker.part_done(WriteStatus::written);
                               }
                               return WriteStatus::written;
                           }),
              "");
    worker.wake(fresh());
    std::this_thread::sleep_for(300ms);
    EXPECT_TRUE(seen_within([&] { return worker.wake(fresh()) == WriteStatus::written; }));
    ends = true;
}

/// A thread without processor time, imitated by a signal handler that keeps it.
class Starved : public testing::Test {
  protected:
    Starved() {
        // NOLINTNEXTLINE(cert-err33-c)
        ::signal(SIGUSR1, [](int) {
            is_kept = true;
            while (kept.load()) {
            }
        });
        kept = true;
        EXPECT_EQ(worker_.start({.now = monotonic_now},
                                [this] {
                                    thread_ = ::syscall(SYS_gettid);
                                    on_pin_ = newest_.load();
                                    return WriteStatus::written;
                                }),
                  "");
        newest_ = 1500;
        EXPECT_EQ(worker_.wake(fresh()), WriteStatus::written);
        EXPECT_TRUE(seen_within([this] { return on_pin_ == 1500; }));
        is_kept = false;
        ::syscall(SYS_tgkill, ::getpid(), thread_.load(), SIGUSR1);
        EXPECT_TRUE(seen_within([] { return is_kept.load(); }));
    }
    ~Starved() override { kept = false; }
    /// Asks for another pulse each period. The life of each frame is told, not waited for.
    WriteStatus ask(int pulse, Instant made) {
        newest_ = pulse;
        return worker_.wake({.made = made, .valid_for = kPeriod});
    }

    inline static std::atomic<bool> kept = false;
    inline static std::atomic<bool> is_kept = false;
    std::atomic<long> thread_ = 0;
    std::atomic<int> newest_ = 0;
    std::atomic<int> on_pin_ = 0;
    LinkWorker worker_;
};

TEST_F(Starved, ThreadDoesNotCountAsWrittenAfterTwoPeriods) {
    const Instant start = monotonic_now() + 1s;
    EXPECT_EQ(ask(1000, start), WriteStatus::written);
    EXPECT_EQ(ask(1001, start + kPeriod), WriteStatus::written);
    EXPECT_EQ(ask(1002, start + 2 * kPeriod), WriteStatus::written);
    for (int i = 3; i < 90; ++i) {
        EXPECT_EQ(ask(1000 + i, start + i * kPeriod), WriteStatus::unavailable) << i;
    }
    EXPECT_EQ(on_pin_, 1500);
}

TEST_F(Starved, ThreadStandsAfterASecond) {
    const Instant start = monotonic_now() + 1s;
    EXPECT_FALSE(worker_.stands(start)) << "nothing is asked for";
    ask(1000, start);
    EXPECT_FALSE(worker_.stands(start + 1000ms));
    EXPECT_TRUE(worker_.stands(start + 1001ms));
}

TEST_F(Starved, ThreadThatGoesOnCountsAsWrittenAgain) {
    ask(1000, monotonic_now());
    kept = false;
    EXPECT_TRUE(seen_within([this] { return on_pin_ == 1000; }));
    EXPECT_TRUE(seen_within([this] {
        return ask(1001, monotonic_now()) == WriteStatus::written &&
               !worker_.stands(monotonic_now());
    }));
}

TEST(LinkWorker, DoesNotStandWhileTheKernelKeepsIt) {
    SlowKernel kernel;
    LinkWorker worker;
    kernel.start(worker);
    worker.wake(fresh());
    ASSERT_TRUE(seen_within([&] { return kernel.begun == 1; }));
    worker.wake(fresh());
    EXPECT_FALSE(worker.stands(monotonic_now() + 10s)) << "a restart would not help";
    kernel.let_go.release(1000);
}

TEST(LinkWorker, EndsWithoutWorkIfNothingWokeIt) {
    std::atomic<int> works = 0;
    {
        LinkWorker worker;
        ASSERT_EQ(worker.start({.now = monotonic_now},
                               [&] {
                                   ++works;
                                   return WriteStatus::written;
                               }),
                  "");
    }
    EXPECT_EQ(works, 0);
    const LinkWorker never_started;
}

}  // namespace
}  // namespace tribus::test::link_worker_test
