#pragma once

#include "transports/links/medium.h"

namespace tribus {

/// The data line of an SPI port as an inverted serial line, without an inverter
/// (docs/boards/spi.md).
extern const Medium kSpiSerialMedium;

}  // namespace tribus
