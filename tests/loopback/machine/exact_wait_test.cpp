#include "pipelines/realtime/exact_wait.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <array>

#include <gtest/gtest.h>

#include "pipelines/realtime/clock.h"
#include "transports/links/unique_fd.h"

namespace tribus::exact_wait_test {
namespace {

using namespace std::chrono_literals;

/// With the kernel's epoll_pwait2, and as on a kernel without it.
class ExactWait : public testing::TestWithParam<bool> {
  protected:
    ExactWait() {
        epoll_event event{};
        event.events = EPOLLIN;
        event.data.u64 = 7;
        ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, wake_up_.get(), &event);
    }
    int wait(timespec timeout) {
        return wait_for_events(epoll_.get(), events_, timeout, GetParam());
    }

    UniqueFd epoll_{::epoll_create1(0)};
    UniqueFd wake_up_{::eventfd(0, EFD_NONBLOCK)};
    std::array<epoll_event, 4> events_{};
};

TEST_P(ExactWait, ReturnsWhatIsReady) {
    const std::uint64_t one = 1;
    ASSERT_EQ(::write(wake_up_.get(), &one, sizeof one), ssize_t{sizeof one});
    EXPECT_EQ(wait({.tv_sec = 10, .tv_nsec = 0}), 1);
    EXPECT_EQ(events_[0].data.u64, 7U);
}

TEST_P(ExactWait, DoesNotReturnBeforeATimeoutThatIsNoWholeMillisecond) {
    const Instant before = monotonic_now();
    EXPECT_EQ(wait({.tv_sec = 0, .tv_nsec = 1'700'000}), 0);
    EXPECT_GE(monotonic_now() - before, 1700us);
}

INSTANTIATE_TEST_SUITE_P(Kernels, ExactWait, testing::Values(true, false));

}  // namespace
}  // namespace tribus::exact_wait_test
