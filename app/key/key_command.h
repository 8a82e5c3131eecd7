#pragma once

#include "app/cli/command.h"

namespace tribus {

/// The subcommand `key`: makes key files of authenticated links, and shows which key a file has.
Command key_command();

}  // namespace tribus
