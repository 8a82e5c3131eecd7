#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/cli/command.h"

namespace tribus {

/// Reads the command line and runs the command that it names. Prints help and the version to
/// standard output, mistakes to standard error. Returns the exit status. Call it once, from main.
/// The descriptions of the commands end before the command runs.
int run_command_line(std::vector<Command> commands, std::string_view version, int argc,
                     char** argv);

/// Type text for an option with a few allowed words, `a, b, c`. Shell completions parse it.
std::string choices_type(std::string_view words);

}  // namespace tribus
