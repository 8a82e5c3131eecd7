#include "transports/links/link_worker.h"

#include <sched.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <limits>
#include <semaphore>
#include <thread>

#include <gtest/gtest.h>

#include "pipelines/realtime/clock.h"
#include "tests/support/fewer_descriptors.h"
#include "tests/support/seen_within.h"
#include "transports/links/start_thread.h"

/// A link's thread with a clock that the test sets, and how the thread starts.
namespace tribus::test::link_worker_clock_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kStart{1000s};
std::atomic<std::int64_t> clock_ns = 0;

Instant test_now() {
    return Instant(Duration(clock_ns.load()));
}

void set_clock(Instant now) {
    clock_ns = now.time_since_epoch().count();
}

/// Its work ends when it is let go, and lasts no time by the clock.
class SetClock : public testing::Test {
  protected:
    SetClock() {
        set_clock(kStart);
        EXPECT_EQ(worker_.start({.now = test_now},
                                [this] {
                                    valid_until_ = worker_.valid_until();
                                    ++begun_;
                                    let_go_.acquire();
                                    return WriteStatus::written;
                                }),
                  "");
    }
    ~SetClock() override { let_go_.release(1000); }

    WriteStatus wake(Instant made, Duration valid_for = 10s) {
        return worker_.wake({.made = made, .valid_for = valid_for});
    }
    bool begins(int time) {
        return seen_within([=, this] { return begun_ == time; });
    }

    std::counting_semaphore<> let_go_{0};
    std::atomic<int> begun_ = 0;
    std::atomic<Instant> valid_until_{};
    LinkWorker worker_;
};

TEST_F(SetClock, ThreadDoesNothingUntilItIsWoken) {
    EXPECT_FALSE(seen_within([this] { return begun_ > 0; }, 50ms));
    EXPECT_FALSE(worker_.stands(kStart + 10s));
}

TEST_F(SetClock, ThreadKnowsHowLongWhatItHandsOverLives) {
    wake(kStart, 30ms);
    ASSERT_TRUE(begins(1));
    EXPECT_EQ(valid_until_.load(), kStart + 30ms);
    EXPECT_FALSE(worker_.is_over(kStart));
    EXPECT_TRUE(worker_.is_over(kStart - 1ns));
}

TEST_F(SetClock, ThreadMayBeKeptByTheKernelFor200Milliseconds) {
    set_clock(kStart + 5s);
    EXPECT_EQ(wake(kStart + 5s), WriteStatus::written) << "it was idle before";
    ASSERT_TRUE(begins(1));
    EXPECT_EQ(wake(kStart + 5s + 200ms), WriteStatus::written);
    EXPECT_EQ(wake(kStart + 5s + 200ms + 1ns), WriteStatus::unavailable);
    EXPECT_FALSE(worker_.stands(kStart + 20s)) << "a restart would not help";
}

TEST_F(SetClock, ThreadThatEndedItsWorkMayBeIdleForEver) {
    let_go_.release(1000);
    wake(kStart);
    ASSERT_TRUE(begins(1));
    EXPECT_TRUE(seen_within([this] { return wake(kStart + 1h) == WriteStatus::written; }))
        << "the thread may be at work just then, but not each time";
    EXPECT_TRUE(seen_within([this] { return !worker_.stands(kStart + 3h); }));
}

TEST_F(SetClock, ThreadGives200MillisecondsToAFrameWithoutALife) {
    const FrameLife life = worker_.life_from_now();
    EXPECT_EQ(life.made, kStart);
    EXPECT_EQ(life.valid_for, 200ms);
}

/// Policy and priority of the thread of a worker.
struct Scheduling {
    int policy = -1;
    int priority = -1;

    bool operator==(const Scheduling&) const = default;
};

Scheduling own_scheduling() {
    sched_param priority{};
    ::sched_getparam(0, &priority);
    return {::sched_getscheduler(0), priority.sched_priority};
}

Scheduling scheduling_of_worker(bool realtime) {
    std::atomic<Scheduling> seen{};
    std::atomic<bool> done = false;
    LinkWorker worker;
    EXPECT_EQ(worker.start({.now = monotonic_now, .realtime = realtime},
                           [&] {
                               seen = own_scheduling();
                               done = true;
                               return WriteStatus::written;
                           }),
              "");
    worker.wake(worker.life_from_now());
    EXPECT_TRUE(seen_within([&] { return done.load(); }));
    return seen;
}

TEST(LinkWorkerThread, IsOfRealTimeOnlyIfAskedAndAllowed) {
    Scheduling allowed;
    std::thread([&] {
        const sched_param priority{.sched_priority = 1};
        ::sched_setscheduler(0, SCHED_FIFO, &priority);
        allowed = own_scheduling();
    }).join();
    EXPECT_EQ(scheduling_of_worker(true), allowed);
    EXPECT_EQ(scheduling_of_worker(false), own_scheduling());
}

TEST(LinkWorkerThread, DoesNotStartWithoutADescriptor) {
    LinkWorker worker;
    const FewerDescriptors fewer(0);
    EXPECT_EQ(worker.start({.now = monotonic_now}, [] { return WriteStatus::written; }),
              "Too many open files");
}

/// In a process of its own: it is for all threads.
TEST(LinkWorkerThread, SaysThatThereIsNoRoomForIt) {
    EXPECT_EXIT(
        {
            const int set = set_usual_stack(std::numeric_limits<std::size_t>::max() / 4);
            LinkWorker worker;
            const std::string problem =
                worker.start({.now = monotonic_now}, [] { return WriteStatus::written; });
            std::_Exit(set == 0 && problem.starts_with("cannot start a thread: ") ? 0 : 1);
        },
        ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace tribus::test::link_worker_clock_test
