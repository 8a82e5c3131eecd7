#pragma once

#include <string>

#include <tl/expected.hpp>

#include "core/distribution.h"
#include "core/time.h"
#include "tests/bench/subject.h"

namespace tribus::bench {

/// Age of the stick values when they are sent, by the schedule of the output.
struct AgeResult {
    Distribution follow;  ///< written on arrival
    Distribution locked;  ///< an even cadence, steered to just after the arrivals
    Distribution free;    ///< a free-running writer, as many programs have
};

/// Runs one `tribus run` with an i.Bus input at the 7.715 ms of a real receiver and three i.Bus
/// outputs at 7 ms. An age is the time from writing the last byte of a frame to the first
/// appearance of its values in an output. The error is a sentence.
tl::expected<AgeResult, std::string> measure_age(const ApplianceSettings& settings,
                                                 Duration length);

}  // namespace tribus::bench
