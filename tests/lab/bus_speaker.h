#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/can_frame.h"
#include "tests/loopback/wire.h"

namespace tribus::test {

/// A healthy sender of sixteen channels on a CAN bus. Its counter increases by one each time.
class BusSpeaker {
  public:
    virtual ~BusSpeaker() = default;
    /// Returns the frames of one snapshot in the order in which they are sent.
    virtual std::vector<CanFrame> frames(const Sticks& sticks) = 0;
};

/// Configuration of an input that reads this sender. Tests are named after `name`.
struct BusLanguage {
    std::string name;
    std::string input;   ///< lines of the table `[input.bus]` without its interface
    std::string tables;  ///< tables that follow it
    std::unique_ptr<BusSpeaker> (*speaker)() = nullptr;
};

/// The native format, DroneCAN's RCInput, and a DBC file of four messages, each with a counter.
const std::vector<BusLanguage>& bus_languages();
/// Writes the DBC file `rc.dbc` into the folder of the configuration.
void write_counted_dbc(const std::filesystem::path& folder);

}  // namespace tribus::test
