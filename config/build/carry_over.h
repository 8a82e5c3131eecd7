#pragma once

#include <string>
#include <vector>

#include "config/schema/schema.h"
#include "pipelines/engine/carry_over.h"

namespace tribus {

/// Whether both name the same device. A path may be a link to it.
bool same_device(const PortConfig& a, const PortConfig& b);

/// What a new configuration takes over from the running one.
///
/// An input continues if its port, protocol and protocol settings are unchanged. An output
/// continues if its port and protocol are unchanged and, on CAN, its protocol settings, because
/// they contain its ids. Other settings may change. A part that was only renamed continues if its
/// port identifies it.
struct CarryOver {
    EngineCarry engine;
    ValueCarry values;
    Leaving leaving;
    /// Reasons why a reload must stop all outputs, as sentences. Empty if none.
    std::vector<std::string> obstacles;
};
/// Compares two valid configurations. Reads only the links of device paths. Main thread.
CarryOver plan_carry_over(const Configuration& running, const Configuration& fresh);

}  // namespace tribus
