#pragma once

#include <string>
#include <vector>

#include "config/schema.h"
#include "pipelines/carry_over.h"

namespace tribus {

/// Both name the same thing: a path may be a link to a device, or another link to it.
bool same_device(const PortConfig& a, const PortConfig& b);

/// What a fresh configuration goes on with of the running one.
///
/// An input goes on if its port, protocol and the protocol's own settings are the same; an output
/// if its port and protocol are, and on CAN, where its ids are its name, the settings too. Their
/// other settings may change. A part that was only renamed goes on as well, where its port tells.
struct CarryOver {
    EngineCarry engine;
    ValueCarry values;
    Leaving leaving;
    /// What cannot change without a stop, as sentences; empty where nothing is in the way.
    std::vector<std::string> obstacles;
};
CarryOver plan_carry_over(const Configuration& running, const Configuration& fresh);

}  // namespace tribus
