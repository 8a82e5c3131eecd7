#pragma once

#include <cstdio>
#include <string_view>

#include <fmt/format.h>

namespace tribus {

/// Prints to standard error why a command failed. Returns the exit status.
inline int complain(std::string_view text, int status) {
    fmt::print(stderr, "tribus: {}\n", text);
    return status;
}

}  // namespace tribus
