#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "app/cli/streams.h"
#include "app/journal/print_error.h"

namespace tribus {

/// Prints to standard error why a command of this program failed: in one line, which a terminal
/// breaks at words. Returns the exit status.
inline int complain(std::string_view text, int status) {
    const std::string line = fmt::format("{}: {}", ::program_invocation_short_name, text);
    if (::isatty(STDERR_FILENO) == 1) {
        tell_person(line);
    } else {
        print_error("{}\n", line);
    }
    return status;
}

}  // namespace tribus
