#include "tests/loopback/machine_stops.h"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <ctime>

namespace tribus::test {
namespace {

using namespace std::chrono_literals;

/// A shorter delay of a thread that sleeps a millisecond is usual.
constexpr Clock::duration kLeastStop = 5ms;
/// More than the priority of the program's threads.
constexpr int kPriority = 90;

}  // namespace

MachineStops::MachineStops() {
    cpu_set_t allowed;
    ::sched_getaffinity(0, sizeof allowed, &allowed);
    for (int processor = 0; processor < CPU_SETSIZE; ++processor) {
        if (CPU_ISSET(static_cast<unsigned>(processor), &allowed)) {
            threads_.emplace_back([this, processor] { watch(processor); });
        }
    }
}

MachineStops::~MachineStops() {
    ends_ = true;
    for (std::thread& thread : threads_) {
        thread.join();
    }
}

void MachineStops::watch(int processor) {
    cpu_set_t own;
    CPU_ZERO(&own);
    CPU_SET(static_cast<unsigned>(processor), &own);
    ::pthread_setaffinity_np(::pthread_self(), sizeof own, &own);
    sched_param priority{};
    priority.sched_priority = kPriority;
    ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority);
    Clock::time_point before = Clock::now();
    while (!ends_) {
        constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 1'000'000};
        ::nanosleep(&kPause, nullptr);
        const Clock::time_point now = Clock::now();
        if (now - before >= kLeastStop) {
            const std::lock_guard lock(mutex_);
            stops_.push_back({before, now});
        }
        before = now;
    }
}

Clock::duration MachineStops::within(Clock::time_point from, Clock::time_point to) {
    const std::lock_guard lock(mutex_);
    Clock::duration sum{};
    for (const Stop& stop : stops_) {
        const Clock::duration part = std::min(stop.to, to) - std::max(stop.from, from);
        sum += std::max(part, Clock::duration::zero());
    }
    return sum;
}

}  // namespace tribus::test
