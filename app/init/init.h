#pragma once

#include "app/command.h"

namespace tribus {

/// `tribus init`.
Command init_command();

}  // namespace tribus
