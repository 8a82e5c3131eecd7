#pragma once

#include "app/cli/command.h"

namespace tribus {

/// `tribus record`: records with the flight recorder of a running daemon, or directly from a port.
Command record_command();

}  // namespace tribus
