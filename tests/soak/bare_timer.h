#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "core/time.h"

namespace tribus::test {

/// Measures what this machine does to any real-time thread while the daemon runs. The thread sleeps
/// until every 7th millisecond, with the daemon's scheduling if permitted. It counts how often it
/// is late by a tenth of that, as the daemon counts its own deadlines.
class BareTimer {
  public:
    BareTimer() : thread_([this] { run(); }) {}
    BareTimer(const BareTimer&) = delete;
    BareTimer& operator=(const BareTimer&) = delete;
    ~BareTimer() {
        ends_ = true;
        thread_.join();
    }

    std::uint64_t wakes() const { return wakes_; }
    std::uint64_t misses() const { return misses_; }

  private:
    void run();

    std::atomic<bool> ends_ = false;
    std::atomic<std::uint64_t> wakes_ = 0;
    std::atomic<std::uint64_t> misses_ = 0;
    std::thread thread_;
};

}  // namespace tribus::test
