#pragma once

#include <atomic>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "tests/loopback/wire.h"

namespace tribus::test {

/// Notes when a processor of this machine ran nothing at all for a while: a virtual machine's host
/// gives time to others, and tells the guest nothing of it. A thread on each processor, with more
/// priority than any program has, sleeps a millisecond again and again. Without the right to that
/// priority it also notes when others take the processor.
class MachineStops {
  public:
    MachineStops();
    ~MachineStops();

    /// How long processors stood still between the two, added up.
    Clock::duration within(Clock::time_point from, Clock::time_point to);

  private:
    struct Stop {
        Clock::time_point from;
        Clock::time_point to;
    };
    void watch(int processor);

    std::mutex mutex_;
    std::vector<Stop> stops_;
    std::atomic<bool> ends_{false};
    std::deque<std::thread> threads_;
};

}  // namespace tribus::test
