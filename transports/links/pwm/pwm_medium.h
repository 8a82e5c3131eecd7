#pragma once

#include "transports/links/medium.h"

namespace tribus {

/// PWM chips of the kernel, as /sys/class/pwm shows them.
extern const Medium kPwmMedium;

}  // namespace tribus
