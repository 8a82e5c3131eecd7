#pragma once

#include <cerrno>
#include <cstdio>
#include <string_view>

#include <fmt/format.h>

namespace tribus {

/// Prints to standard error why a command of this program failed. Returns the exit status.
inline int complain(std::string_view text, int status) {
    fmt::print(stderr, "{}: {}\n", ::program_invocation_short_name, text);
    return status;
}

}  // namespace tribus
