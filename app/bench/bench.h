#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The subcommand `bench`: measures what tribus adds on this machine, beside the minimum of any
/// program.
Command bench_command();

}  // namespace tribus
