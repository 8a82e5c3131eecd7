#pragma once

#include <functional>

#include <tl/expected.hpp>

#include "app/cli/build_facts.h"
#include "app/cli/command.h"

namespace tribus {

/// Reads the command line and runs the command that it names. Prints help and the version to
/// standard output, mistakes to standard error. Returns the exit status: that of the command, or 1
/// if standard output could not be written. Call it once, from main. The descriptions of the
/// commands end before the command runs.
int run_command_line(const std::function<Program()>& make_program, const BuildFacts& built,
                     int argc, char** argv);

/// Sets the options of the command that the words name, and returns what it does. Instead, the exit
/// status, if the words ask for help or cannot be used.
tl::expected<std::function<int()>, int> read_command_line(Program& program, const BuildFacts& built,
                                                          int argc, const char* const* argv);

}  // namespace tribus
