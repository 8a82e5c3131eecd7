#pragma once

#include <string>

#include <tl/expected.hpp>

#include "app/bench/distribution.h"
#include "app/bench/subject.h"
#include "core/time.h"

namespace tribus::bench {

/// How old the values of the sticks are when they leave, by the output's schedule.
struct AgeResult {
    Distribution follow;  ///< written on arrival
    Distribution locked;  ///< an even cadence, steered to stand just behind the arrivals
    Distribution free;    ///< a free-running writer: what many programs do
};

/// One `tribus run` with an i.Bus input at the 7.715 ms of a real receiver and three i.Bus outputs
/// at 7 ms. An age is the time from the write of a frame's last byte to the first appearance of its
/// values in an output. The error is a sentence.
tl::expected<AgeResult, std::string> measure_age(const ApplianceSettings& settings,
                                                 Duration length);

}  // namespace tribus::bench
