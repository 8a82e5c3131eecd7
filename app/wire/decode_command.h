#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The subcommand `decode`: decodes recorded bytes or CAN frames to channel frames.
Command decode_command();

}  // namespace tribus
