#pragma once

#include "app/cli/command.h"

namespace tribus::web {

/// `tribus-web plot`: a recording as JSON for a picture. A process of its own, with limits of
/// memory and time, because a recording may be long or damaged.
Command plot_command();

}  // namespace tribus::web
