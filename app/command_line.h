#pragma once

#include <span>
#include <string>
#include <string_view>

#include "app/command.h"

namespace tribus {

/// Reads the command line and runs the command that it names. Help and the version go to standard
/// output, mistakes to standard error. Returns the exit status. To be called once, by main.
int run_command_line(std::span<const Command> commands, std::string_view version, int argc,
                     char** argv);

/// How help shows that an option has a few allowed words, `a, b, c`; completions read it.
std::string choices_type(std::string_view words);

}  // namespace tribus
