#include "tests/bench/tester.h"

#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>

#include "pipelines/realtime/clock.h"

namespace tribus::bench {
namespace {

/// Above the data thread and everything that users probably configured.
constexpr int kTesterPriority = 90;

volatile std::sig_atomic_t interruption = 0;

void note_interruption(int /*signal*/) {
    interruption = 1;
}

}  // namespace

AwakeProcessors::AwakeProcessors()
    : request_(::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC)) {
    const std::int32_t most_microseconds = 0;
    if (request_.valid() && ::write(request_.get(), &most_microseconds, sizeof most_microseconds) !=
                                static_cast<ssize_t>(sizeof most_microseconds)) {
        request_.reset();
    }
}

TesterPriority::TesterPriority() {
    ::pthread_getaffinity_np(::pthread_self(), sizeof old_cpus_, &old_cpus_);
    ::pthread_getschedparam(::pthread_self(), &old_policy_, &old_parameters_);
    if (processor_count() > 1) {
        cpu_set_t first;
        CPU_ZERO(&first);
        CPU_SET(0, &first);
        ::pthread_setaffinity_np(::pthread_self(), sizeof first, &first);
    }
    const sched_param parameters{.sched_priority = kTesterPriority};
    ::sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters);
    locked_ = ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
}

TesterPriority::~TesterPriority() {
    ::sched_setscheduler(0, old_policy_, &old_parameters_);
    ::pthread_setaffinity_np(::pthread_self(), sizeof old_cpus_, &old_cpus_);
    if (locked_) {
        ::munlockall();
    }
}

int processor_count() {
    return static_cast<int>(std::max(1L, ::sysconf(_SC_NPROCESSORS_ONLN)));
}

void sleep_until(Instant instant) {
    const timespec until = as_timespec(instant.time_since_epoch());
    ::clock_nanosleep(kClock, TIMER_ABSTIME, &until, nullptr);
}

void watch_for_interruption() {
    struct sigaction action {};
    action.sa_handler = note_interruption;
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() {
    return interruption != 0;
}

}  // namespace tribus::bench
