#include "transports/links/link_worker.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <semaphore>
#include <thread>

#include <gtest/gtest.h>

namespace tribus::test::link_worker_test {
namespace {

using namespace std::chrono_literals;

/// Waits, at most ten seconds.
bool comes(const std::function<bool()>& condition) {
    for (int i = 0; i < 1000 && !condition(); ++i) {
        std::this_thread::sleep_for(10ms);
    }
    return condition();
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
        ASSERT_EQ(worker.start([this] {
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
    EXPECT_EQ(worker.wake(), WriteStatus::written);
    ASSERT_TRUE(comes([&] { return kernel.begun == 1; }));
    for (int i = 0; i < 5; ++i) {
        worker.wake();
    }
    kernel.let_go.release(2);
    EXPECT_TRUE(comes([&] { return kernel.begun == 2; }));
    std::this_thread::sleep_for(50ms);
    EXPECT_EQ(kernel.begun, 2);
}

TEST(LinkWorker, IsUnavailableWhileTheKernelKeepsItAndOnlyThen) {
    SlowKernel kernel;
    LinkWorker worker;
    kernel.start(worker);
    worker.wake();
    EXPECT_TRUE(comes([&] { return worker.wake() == WriteStatus::unavailable; }));
    EXPECT_EQ(worker.wake(), WriteStatus::unavailable) << "it is not forgotten";
    kernel.let_go.release(1000);
    EXPECT_TRUE(comes([&] { return worker.wake() == WriteStatus::written; }));
    // Idle for longer than any part of the work may take.
    std::this_thread::sleep_for(300ms);
    EXPECT_EQ(worker.wake(), WriteStatus::written);
}

TEST(LinkWorker, TellsTheOutcomeOfTheWorkThatWasDoneLast) {
    std::atomic<WriteStatus> outcome = WriteStatus::lost;
    LinkWorker worker;
    ASSERT_EQ(worker.start([&] { return outcome.load(); }), "");
    EXPECT_TRUE(comes([&] { return worker.wake() == WriteStatus::lost; }));
    outcome = WriteStatus::written;
    EXPECT_TRUE(comes([&] { return worker.wake() == WriteStatus::written; }));
}

TEST(LinkWorker, TellsAPartThatFailedBeforeTheWorkIsDone) {
    SlowKernel kernel;
    LinkWorker worker;
    ASSERT_EQ(worker.start([&] {
        worker.part_done(WriteStatus::lost);
        kernel.take();
        return WriteStatus::written;
    }),
              "");
    worker.wake();
    EXPECT_TRUE(comes([&] { return worker.wake() == WriteStatus::lost; }));
    kernel.let_go.release(1000);
}

TEST(LinkWorker, MayTakeLongForManyPartsThatAreShort) {
    std::atomic<bool> ends = false;
    LinkWorker worker;
    ASSERT_EQ(worker.start([&] {
        while (!ends) {
            worker.part_done(WriteStatus::written);
        }
        return WriteStatus::written;
    }),
              "");
    worker.wake();
    std::this_thread::sleep_for(300ms);
    EXPECT_TRUE(comes([&] { return worker.wake() == WriteStatus::written; }));
    ends = true;
}

TEST(LinkWorker, EndsWithoutWorkIfNothingWokeIt) {
    std::atomic<int> works = 0;
    {
        LinkWorker worker;
        ASSERT_EQ(worker.start([&] {
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
