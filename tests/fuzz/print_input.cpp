#include <cstdio>

#include "tests/fuzz/fuzz.h"

namespace tribus::fuzz::print_input_target {

/// Prints its input, for the test of the driver.
FUZZ_TARGET(print_input) {
    for (const std::uint8_t byte : std::span(data, size)) {
        std::printf("%02x", byte);
    }
    std::printf("\n");
    return 0;
}

}  // namespace tribus::fuzz::print_input_target
