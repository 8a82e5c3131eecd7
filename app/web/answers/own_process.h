#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include <tl/expected.hpp>

namespace tribus::web {

/// Descriptors that a new process gets. `error` of -1: that of this one.
struct ProcessFiles {
    int input = -1;
    int output = -1;
    int error = -1;
};

/// Starts this same program once more, as `tribus-web WORD...`. Signals reach it, although this
/// program blocks some. The caller waits for its end. The error is an errno value.
tl::expected<pid_t, int> start_own_program(const std::vector<std::string>& words,
                                           const ProcessFiles& files);

}  // namespace tribus::web
