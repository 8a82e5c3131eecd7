#pragma once

#include <filesystem>
#include <string>

#include "tests/loopback/program.h"

namespace tribus::test {

/// `candump -L` of can-utils at work on one interface: hears all frames from its construction on.
class Candump {
  public:
    /// Create it before sockets of the test that hear everything, too: it is known to listen when
    /// the kernel has such a socket.
    Candump(const std::filesystem::path& folder, const std::string& interface);

    /// Ends it; the log of all that was on the bus.
    std::string log();

  private:
    Program program_;
};

}  // namespace tribus::test
