#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace tribus::test {

/// A byte as a UART has read it.
struct UartByte {
    std::uint8_t value = 0;
    bool parity_error = false;
    bool framing_error = false;
};

/// How an independent UART reads: as servos and receivers have it, with 16 samples a bit and the
/// majority of the three in the middle. `rate_error`: how much faster than it should its clock is.
struct PlainUart {
    double baud = 100'000;
    bool even_parity = true;
    int stop_bits = 2;
    bool inverted = true;
    double rate_error = 0;

    /// Reads a line from one time to another. `level`: whether it is high at a time in us.
    std::vector<UartByte> read(const std::function<bool(double us)>& level, double from_us,
                               double to_us) const;
};

}  // namespace tribus::test
