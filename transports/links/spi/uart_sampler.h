#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/line_settings.h"
#include "transports/links/spi/waveform.h"

namespace tribus {

/// A byte that was found in samples.
struct SampledByte {
    std::uint8_t value = 0;
    bool damaged = false;   ///< parity or framing error; then the value is meaningless
    std::size_t begin = 0;  ///< sample of its start bit, the first of a block is 0
};

/// The bytes in one block of samples.
struct SampledBlock {
    /// Each bit is a byte of samples; a byte has ten bits at least, of which the last may be short.
    std::array<SampledByte, kMostWaveformBytes / 9> bytes{};
    std::size_t count = 0;
    /// The block ends within a byte, or directly behind one.
    bool cut = false;

    std::span<const SampledByte> view() const { return {bytes.data(), count}; }
};

inline constexpr std::size_t kSamplesPerBit = 8;

/// Finds the bytes of an asynchronous serial line in samples of its level, eight a bit, the first
/// in the highest bit of each byte. Each byte is read from its own start bit on, by the majority of
/// five samples around the middle of each bit, so that a sender may be up to 3 % faster or slower.
/// What the block begins within is left out: the line must have been at rest for as long as a byte
/// lasts. Pure and reentrant, no heap.
void sample_uart(std::span<const std::uint8_t> samples, const LineSettings& line,
                 SampledBlock& block);

}  // namespace tribus
