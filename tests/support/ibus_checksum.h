#pragma once

#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace tribus::test {

/// Returns 0xFFFF minus each byte of `before` (docs/protocols/ibus.md, "Servo frame").
inline std::uint16_t ibus_checksum(std::span<const std::uint8_t> before) {
    return static_cast<std::uint16_t>(
        std::accumulate(before.begin(), before.end(), 0xFFFF,
                        [](int sum, std::uint8_t byte) { return sum - byte; }));
}

/// Appends the checksum to a servo or sensor frame that lacks only that.
inline std::vector<std::uint8_t> with_ibus_checksum(std::vector<std::uint8_t> frame) {
    const std::uint16_t checksum = ibus_checksum(frame);
    frame.push_back(static_cast<std::uint8_t>(checksum));
    frame.push_back(static_cast<std::uint8_t>(checksum >> 8U));
    return frame;
}

}  // namespace tribus::test
