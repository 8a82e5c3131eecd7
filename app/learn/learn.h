#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The subcommand `learn`: finds the detectors that recognise a receiver's loss.
Command learn_command();

}  // namespace tribus
