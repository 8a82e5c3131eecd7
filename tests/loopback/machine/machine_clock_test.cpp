#include "pipelines/realtime/clock.h"

#include <sched.h>
#include <sys/timex.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <fstream>
#include <optional>

#include <gtest/gtest.h>

namespace tribus::test::machine_clock_test {
namespace {

/// Runs `look` in a child with its own time namespace, in which the machine has been suspended for
/// a day. Returns its result, or nothing if the kernel has no time namespaces or the user may not
/// create them.
template <class Look>
std::optional<bool> after_a_day_asleep(Look look) {
    constexpr int kNotPossible = 2;
    const pid_t maker = ::fork();
    if (maker == 0) {
        if (::unshare(CLONE_NEWUSER | CLONE_NEWTIME) != 0 ||
            !(std::ofstream("/proc/self/timens_offsets") << "boottime 86400 0\n"
                                                         << std::flush)) {
            ::_exit(kNotPossible);
        }
        const pid_t child = ::fork();
        if (child == 0) {
            ::_exit(look() ? 0 : 1);
        }
        int status = 0;
        ::waitpid(child, &status, 0);
        ::_exit(WEXITSTATUS(status));
    }
    int status = 0;
    ::waitpid(maker, &status, 0);
    return WEXITSTATUS(status) == kNotPossible ? std::nullopt
                                               : std::optional(WEXITSTATUS(status) == 0);
}

TEST(Clock, CountsTheTimeInWhichTheMachineWasSuspended) {
    const auto counts = after_a_day_asleep([] {
        const Duration awake = awake_time_now();
        return monotonic_now().time_since_epoch() - awake >= std::chrono::hours(24);
    });
    if (!counts) {
        GTEST_SKIP() << "no time name spaces here";
    }
    EXPECT_TRUE(*counts);
}

/// Asks another program what the kernel says, as timedatectl does.
TEST(WallClockOfTheMachine, IsSetWhileTheKernelKnowsHowFarItIsOff) {
    follow_wall_clock();
    timex asked{};
    ASSERT_GE(::adjtimex(&asked), 0);
    EXPECT_EQ(wall_clock().is_set(), asked.maxerror < 16'000'000);
}

Duration raw_time_now() {
    timespec raw{};
    ::clock_gettime(CLOCK_MONOTONIC_RAW, &raw);
    return std::chrono::seconds(raw.tv_sec) + std::chrono::nanoseconds(raw.tv_nsec);
}

TEST(WallClockOfTheMachine, KnowsTheTimeByAClockWhoseRateNobodyAdjusts) {
    follow_wall_clock();
    const Duration slept = monotonic_now().time_since_epoch() - awake_time_now();
    const Duration before = raw_time_now() + slept;
    const Duration told = wall_clock().unslewed(monotonic_now()).time_since_epoch();
    const Duration after = raw_time_now() + slept;
    // `slept` is wrong by as much as a busy machine takes between two clocks, a fraction of it all.
    constexpr Duration kLittle = std::chrono::milliseconds(50);
    EXPECT_GT(told, before - kLittle);
    EXPECT_LT(told, after + kLittle);
}

}  // namespace
}  // namespace tribus::test::machine_clock_test
