#pragma once

#include "core/arrival_clock.h"

namespace tribus::test::arrivals {

inline Instant at(Duration since_start) {
    return Instant(since_start);
}

inline ArrivalClock arrivals_each(Duration interval, Instant first, int count) {
    ArrivalClock arrivals;
    for (int i = 0; i < count; ++i) {
        arrivals.arrived(first + i * interval);
    }
    return arrivals;
}

}  // namespace tribus::test::arrivals
