#pragma once

#include <cstdint>
#include <span>

#include "transports/links/spi/spi_link.h"
#include "transports/links/spi/waveform.h"

namespace tribus {

/// Draws the records of core/edge_records.h: at each edge the line goes up for 300 us; the pause
/// behind the last edge is drawn, the one before the first is not. The line is down at the end. One
/// bit is one microsecond of a clock that runs `calibration` times as fast as it should. Returns
/// false if there is no edge, or no room. Pure and reentrant, no heap.
bool draw_pulses(std::span<const std::uint8_t> records, double calibration, SpiWaveform& waveform);

/// The same for a link: a byte of the port is eight microseconds.
SpiSignal pulse_signal(double calibration);

}  // namespace tribus
