#pragma once

#include <vector>

#include "config/mistakes.h"
#include "config/schema.h"

/// Mistakes that only the machine shows on which a configuration is to run. All but what is wrong
/// for good may change and is none: a device that is not plugged in.
namespace tribus {

/// Devices at whose path something else stands that can never be a serial port: /dev/null, a
/// folder.
std::vector<Mistake> mistaken_devices(const Configuration& configuration);

/// A processor that a machine with so many does not have.
std::vector<Mistake> mistaken_processor(const Configuration& configuration, int processors);

/// Of this machine, also those that are switched off.
int configured_processors();

}  // namespace tribus
