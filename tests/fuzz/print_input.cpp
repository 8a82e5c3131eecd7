#include <cstdio>

#include "tests/fuzz/fuzz.h"

/// Prints its input, for the test of the driver.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    for (const std::uint8_t byte : std::span(data, size)) {
        std::printf("%02x", byte);
    }
    std::printf("\n");
    return 0;
}
