#pragma once

#include <string>

#include <tl/expected.hpp>

#include "transports/links/unique_fd.h"

namespace tribus {

/// A pseudo-terminal: the program at its near end opens `path`, the far end is `master`, which
/// does not block. The error is a sentence.
struct Pty {
    UniqueFd master;
    std::string path;
    static tl::expected<Pty, std::string> open();
};

}  // namespace tribus
