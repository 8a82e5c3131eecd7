#pragma once

#include "app/cli/command.h"

namespace tribus {

/// `tribus status`: a summary of a running daemon for scripts, once or at each change.
Command status_command();

}  // namespace tribus
