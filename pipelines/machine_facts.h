#pragma once

#include <array>
#include <cstddef>

#include "pipelines/health_watch.h"

namespace tribus {

/// What a board may tell of itself, as the named values machine.FACT.
inline constexpr std::array<FactName, 6> kMachineFacts{{
    {"temperature", "degC"},  // the hottest of the board's thermal zones
    {"load", "%"},            // of all processors, since the look before
    {"memory", "%"},          // in use, of all that there is
    {"supply", "V"},          // the highest voltage of the supplies that are there
    {"undervoltage", ""},     // 1 while the supply is too low, as Raspberry Pi boards tell
    {"uptime", "s"},          // since the start of the system
}};
inline constexpr std::size_t kMachineFactCount = kMachineFacts.size();

}  // namespace tribus
