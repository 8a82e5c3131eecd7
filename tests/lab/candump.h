#pragma once

#include <filesystem>
#include <string>

#include "tests/loopback/program.h"

namespace tribus::test {

/// Runs `candump -L` of can-utils on one interface. It logs all frames after the construction.
class Candump {
  public:
    /// Create it before any socket of the test that receives everything: such a socket in the
    /// kernel shows that candump is ready.
    Candump(const std::filesystem::path& folder, const std::string& interface);

    /// Ends candump. Returns the log of everything that was on the bus.
    std::string log();

  private:
    Program program_;
};

}  // namespace tribus::test
