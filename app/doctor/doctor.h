#pragma once

#include "app/command.h"

namespace tribus {

/// The subcommand `doctor`: what this machine's ports can do, what they hear, and what to mend.
Command doctor_command();

}  // namespace tribus
