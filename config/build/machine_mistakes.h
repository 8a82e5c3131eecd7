#pragma once

#include <vector>

#include "config/language/mistakes.h"
#include "config/schema/schema.h"

/// Mistakes that depend on the machine that runs the configuration. Anything that may still change,
/// such as a device that is not plugged in, is not a mistake.
namespace tribus {

/// Devices whose path is something that can never be a serial port: /dev/null, a folder.
std::vector<Mistake> mistaken_devices(const Configuration& configuration);

/// A `cpu` that a machine with this number of processors does not have.
std::vector<Mistake> mistaken_processor(const Configuration& configuration, int processors);

/// Number of processors of this machine, including those that are switched off.
int configured_processors();

}  // namespace tribus
