#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tribus {

/// The most bytes that the kernel takes at once, unless somebody set a larger buffer.
inline constexpr std::size_t kMostWaveformBytes = 4096;

/// A line of pulses as bits, the highest of each byte first. `bytes` is how many are used.
struct Waveform {
    std::array<std::uint8_t, kMostWaveformBytes> bits{};
    std::size_t bytes = 0;
};

/// Draws the records of core/edge_records.h: at each edge the line goes up for 300 us; the pause
/// behind the last edge is drawn, the one before the first is not. The line is down at the end. One
/// bit is one microsecond of a clock that runs `calibration` times as fast as it should. Returns
/// false if there is no edge, or no room. Pure and reentrant, no heap.
bool draw_pulses(std::span<const std::uint8_t> records, double calibration, Waveform& waveform);

}  // namespace tribus
