#pragma once

#include <string>

#include <tl/expected.hpp>

#include "transports/links/unique_fd.h"

namespace tribus {

/// A pseudo-terminal: another program opens `path`; `master` is this program's end and does not
/// block. The error is a sentence.
struct Pty {
    UniqueFd master;
    std::string path;
    static tl::expected<Pty, std::string> open();
};

}  // namespace tribus
