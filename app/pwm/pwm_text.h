#pragma once

#include <cstddef>
#include <string>

#include "transports/links/pwm/pwm_chip.h"

namespace tribus {

/// "pwmchip0  pca9685-pwm, outputs 0 to 15". Pure.
std::string pwm_chip_text(const PwmChipFacts& chip);

/// "on    1500.0 us each 20.000 ms". Pure.
std::string pwm_output_text(const PwmOutputFacts& facts);

}  // namespace tribus
