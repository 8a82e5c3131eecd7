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

    /// Ends candump once it has logged what was on the bus before, and returns that.
    std::string log();

  private:
    std::string interface_;
    Program program_;
};

}  // namespace tribus::test
