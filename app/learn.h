#pragma once

#include "app/command.h"

namespace tribus {

/// The subcommand `learn`: which detectors recognise the loss of a receiver's link.
Command learn_command();

}  // namespace tribus
