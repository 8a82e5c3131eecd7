#pragma once

#include "transports/links/medium.h"

namespace tribus {

/// A line of pulses: a GPIO line in, the data line of an SPI port out (docs/protocols/ppm.md).
extern const Medium kPulseLineMedium;

}  // namespace tribus
