#pragma once

#include <array>
#include <cstddef>

#include "pipelines/engine/health_watch.h"

namespace tribus {

/// Facts that a board can report about itself, as the named values machine.FACT.
inline constexpr std::array<FactName, 6> kMachineFacts{{
    {"temperature", "degC"},  // hottest thermal zone of the board
    {"load", "%"},            // of all processors, since the sample before
    {"memory", "%"},          // in use, share of all memory
    {"supply", "V"},          // highest voltage of the power supplies
    // 1 while the supply voltage is too low, as Raspberry Pi boards report
    {"undervoltage", ""},
    {"uptime", "s"},  // since the start of the system
}};
inline constexpr std::size_t kMachineFactCount = kMachineFacts.size();

}  // namespace tribus
