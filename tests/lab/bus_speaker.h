#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/can_frame.h"
#include "tests/loopback/wire.h"

namespace tribus::test {

/// A healthy sender of sixteen channels on a CAN bus, whose counter goes on by one each time.
class BusSpeaker {
  public:
    virtual ~BusSpeaker() = default;
    /// The frames of one snapshot, in the order in which they are sent.
    virtual std::vector<CanFrame> frames(const Sticks& sticks) = 0;
};

/// What an input needs to read it. Tests are named for `name`.
struct BusLanguage {
    std::string name;
    std::string input;   ///< lines of the table `[input.bus]` without its interface
    std::string tables;  ///< that follow it
    std::unique_ptr<BusSpeaker> (*speaker)() = nullptr;
};

/// The native format, DroneCAN's RCInput, and a DBC file of four messages with a counter in each.
const std::vector<BusLanguage>& bus_languages();
/// The DBC file, `rc.dbc`, into the folder of the configuration.
void write_counted_dbc(const std::filesystem::path& folder);

}  // namespace tribus::test
