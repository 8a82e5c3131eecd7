#pragma once

#include <cstdint>

#include "core/time.h"

namespace tribus {

enum class Parity : std::uint8_t { none, even };

/// How bytes travel on an asynchronous serial line: eight data bits, least significant first.
struct LineSettings {
    std::uint32_t baud = 115200;
    Parity parity = Parity::none;
    std::uint8_t stop_bits = 1;
    /// The line idles low and the start bit is high (SBUS; docs/protocols/sbus.md, "Line"). The
    /// wiring decides this; the serial port cannot invert.
    bool inverted_wire = false;

    bool operator==(const LineSettings&) const = default;

    /// Start bit, data, parity, stop bits.
    constexpr unsigned bits_per_byte() const {
        return 1U + 8U + (parity == Parity::even ? 1U : 0U) + stop_bits;
    }
    /// Duration of `bits` on the line.
    constexpr Duration bits_time(std::uint64_t bits) const {
        return Duration(static_cast<std::int64_t>((bits * 1'000'000'000U + baud / 2) / baud));
    }
    constexpr Duration bytes_time(std::uint64_t bytes) const {
        return bits_time(bytes * bits_per_byte());
    }
};

}  // namespace tribus
