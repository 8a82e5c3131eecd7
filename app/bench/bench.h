#pragma once

#include "app/command.h"

namespace tribus {

/// The subcommand `bench`: what the appliance adds on this machine, beside the least that any
/// program would.
Command bench_command();

}  // namespace tribus
