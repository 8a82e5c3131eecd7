#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include <tl/expected.hpp>

#include "core/distribution.h"
#include "core/time.h"

namespace tribus::bench {

/// How far the pulses of a receiver at rest are from each other's middle.
struct PpmResult {
    /// How far each pulse of each frame is from the median of its channel, by the kernel's time
    /// stamps, as tribus reads PPM.
    Distribution stamped;
    /// The same by the clock that a reader reads when it wakes.
    Distribution bare;
    std::size_t channels = 0;
    std::size_t frames = 0;
    std::uint64_t refused = 0;
};

/// Reads PPM from a GPIO line for `length`, while all sticks rest. The error says what to do.
tl::expected<PpmResult, std::string> measure_ppm(const std::string& line, Duration length);

}  // namespace tribus::bench
