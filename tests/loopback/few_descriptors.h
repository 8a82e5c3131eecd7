#pragma once

#include <string>

#include "tests/loopback/loopback.h"

namespace tribus::test {

/// What the daemon did with each number of descriptors that it was allowed.
struct DescriptorTrials {
    int ended = 0;  ///< it said that there are too few, and ended
    int ran = 0;    ///< it started, and missed nothing
};

/// Runs the configuration with 4 to 32 descriptors. Anything but an end that names the reason, or
/// a start at which no device is missing, fails the test.
DescriptorTrials run_with_few_descriptors(const std::filesystem::path& folder,
                                          const std::string& file);

}  // namespace tribus::test
