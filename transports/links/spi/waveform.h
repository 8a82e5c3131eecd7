#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tribus {

/// The most bytes that the kernel takes at once, unless somebody set a larger buffer.
inline constexpr std::size_t kMostWaveformBytes = 4096;

/// Bits that the data line of an SPI port draws, the highest of each byte first. `bytes` is how
/// many bytes are used.
struct SpiWaveform {
    std::array<std::uint8_t, kMostWaveformBytes> bits{};
    std::size_t bytes = 0;
};

}  // namespace tribus
