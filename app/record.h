#pragma once

#include "app/command.h"

namespace tribus {

/// `tribus record`: a recording of the flight recorder of a running daemon, or of a port by itself.
Command record_command();

}  // namespace tribus
