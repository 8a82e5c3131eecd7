#include "transports/links/can/clock_step.h"

#include <chrono>

namespace tribus {

bool ClockStep::since_last_look(Duration wall_time, Instant now) const {
    // The two clocks are not read at the same instant, and the kernel slews by 500 ppm.
    constexpr Duration kApart = std::chrono::milliseconds(10);
    constexpr int kSlewing = 1000;
    if (!latest_) {
        return false;
    }
    const Duration passed = now - latest_->at;
    return std::chrono::abs(wall_time - latest_->wall_time - passed) > kApart + passed / kSlewing;
}

void ClockStep::look(Duration wall_time, Instant now) {
    latest_ = {.wall_time = wall_time, .at = now};
}

}  // namespace tribus
