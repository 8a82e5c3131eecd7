#pragma once

#include <cstdint>
#include <span>

#include "core/line_settings.h"
#include "transports/links/spi/waveform.h"

namespace tribus {

/// Draws bytes as an asynchronous serial line carries them: one byte of the SPI port is one bit of
/// that line, so that its level never changes within such a byte, and clocks between bytes only
/// lengthen all bits alike. The line rests at the begin and at the end. Returns false if there are
/// no bytes, or no room. Pure and reentrant, no heap.
bool draw_uart(std::span<const std::uint8_t> bytes, const LineSettings& line,
               SpiWaveform& waveform);

}  // namespace tribus
