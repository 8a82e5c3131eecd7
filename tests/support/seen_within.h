#pragma once

#include <chrono>
#include <thread>

#include "core/time.h"
#include "pipelines/realtime/clock.h"

namespace tribus::test {

/// Asks each 7 ms, as often as a receiver sends, until `condition` is true. False if it is not true
/// within `patience`, which is longer than anything takes on a busy machine.
template <class Condition>
[[nodiscard]] bool seen_within(Condition condition, Duration patience = std::chrono::seconds(30)) {
    const Instant end = monotonic_now() + patience;
    while (!condition()) {
        if (monotonic_now() > end) {
            return false;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(7));
    }
    return true;
}

}  // namespace tribus::test
