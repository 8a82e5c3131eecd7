#pragma once

#include "transports/links/medium.h"

namespace tribus {

/// The data lines of an SPI port as inverted serial lines, without an inverter
/// (docs/boards/spi.md).
extern const Medium kSpiSerialMedium;

}  // namespace tribus
